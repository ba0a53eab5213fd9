"""The right-angle frame in motion by Exudyn: wanted values of the case "Frame, pushed" of `lissom validate`.

    pip install exudyn==1.13.6
    python benches/python/peers/exudyn_frame.py          # about two minutes

Prints the extremes with 20, 40 and 80 elements a leg and, as errors fall with the square of the length of the
elements, those extrapolated from each pair. Shares nothing with lissom: two-node elements, Euler parameters,
joints.
"""

from itertools import pairwise

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    GenericJoint,
    LoadForceVector,
    MarkerNodePosition,
    MarkerNodeRigid,
    NodePointGround,
    NodeRigidBodyEP,
    ObjectBeamGeometricallyExact,
    SensorNode,
)

# Simo and Vu-Quoc (1988), example 5.2. Exudyn's order is stretch, shear, shear, torsion, bending, bending.
LEG = 10.0
STIFFNESS = (1e6, 1e6, 1e6, 1e3, 1e3, 1e3)
MASS, INERTIA = 1.0, (20.0, 10.0, 10.0)
PUSH_TIMES, PUSH = (0.0, 1.0, 2.0), (0.0, 50.0, 0.0)
END, STEP, OUTPUT_STEP = 30.0, 5e-3, 1e-2
ELEMENTS = (20, 40, 80)
# Of Newton's method: with smaller ones it stops at rounding.
TOLERANCE = 1e-6

QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
QUARTER_TURN_PARAMETERS = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
NO_TURN_PARAMETERS = [1.0, 0.0, 0.0, 0.0]


def pushing(system, t, load):
    return [0.0, 0.0, float(np.interp(t, PUSH_TIMES, PUSH))]


def displacements(elements: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, and displacements of the tip and of the elbow across the plane."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    section = exu.BeamSection()
    section.stiffnessMatrix = np.diag(STIFFNESS)
    section.inertia = np.diag(INERTIA)
    section.massPerLength = MASS
    along = np.linspace(0.0, LEG, elements + 1)

    def leg(places, parameters):
        nodes = [
            system.AddNode(NodeRigidBodyEP(referenceCoordinates=[*place, *parameters])) for place in places
        ]
        for pair in pairwise(nodes):
            beam = ObjectBeamGeometricallyExact(
                nodeNumbers=list(pair), length=LEG / elements, sectionData=section
            )
            system.AddObject(beam)
        return nodes

    first = leg([(0.0, s, 0.0) for s in along], QUARTER_TURN_PARAMETERS)
    second = leg([(s, LEG, 0.0) for s in along], NO_TURN_PARAMETERS)

    def weld(node, other, turn):
        markers = [system.AddMarker(MarkerNodeRigid(nodeNumber=number)) for number in (node, other)]
        system.AddObject(GenericJoint(markerNumbers=markers, rotationMarker0=turn))

    weld(system.AddNode(NodePointGround()), first[0], QUARTER_TURN)
    weld(first[-1], second[0], QUARTER_TURN.T)
    elbow = system.AddMarker(MarkerNodePosition(nodeNumber=first[-1]))
    system.AddLoad(
        LoadForceVector(markerNumber=elbow, loadVector=[0.0, 0.0, 0.0], loadVectorUserFunction=pushing)
    )
    sensors = [
        system.AddSensor(
            SensorNode(
                nodeNumber=node,
                outputVariableType=exu.OutputVariableType.Displacement,
                storeInternal=True,
                writeToFile=False,
            )
        )
        for node in (second[-1], first[-1])
    ]
    system.Assemble()

    settings = exu.SimulationSettings()
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = OUTPUT_STEP
    stepping = settings.timeIntegration
    stepping.numberOfSteps, stepping.endTime = round(END / STEP), END
    stepping.generalizedAlpha.spectralRadius = 1.0
    stepping.newton.useModifiedNewton = False
    stepping.newton.relativeTolerance = stepping.newton.absoluteTolerance = TOLERANCE
    system.SolveDynamic(settings)
    tip, elbow = (system.GetSensorStoredData(sensor) for sensor in sensors)
    return tip[:, 0], tip[:, 3], elbow[:, 3]


def extreme(t: np.ndarray, values: np.ndarray, at: int) -> tuple[float, float]:
    """The extreme of the parabola through three neighbours, and its time."""
    before, middle, after = values[at - 1 : at + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * middle + after)
    return middle - 0.25 * (before - after) * shift, t[at] + shift * (t[1] - t[0])


def extremes(elements: int) -> np.ndarray:
    """Largest and smallest of the tip, smallest of the elbow, each with its time."""
    t, tip, elbow = displacements(elements)
    return np.array(
        [
            *extreme(t, tip, tip.argmax()),
            *extreme(t, tip, tip.argmin()),
            *extreme(t, elbow, elbow.argmin()),
        ]
    )


def main() -> None:
    coarse = None
    for elements in ELEMENTS:
        fine = extremes(elements)
        print(f"{elements} elements a leg:", *(f"{value:.5f}" for value in fine))
        if coarse is not None:
            print("  extrapolated:", *(f"{value:.5f}" for value in fine + (fine - coarse) / 3.0))
        coarse = fine


if __name__ == "__main__":
    main()
