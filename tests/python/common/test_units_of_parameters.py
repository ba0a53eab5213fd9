"""Units that reports write beside parameters are those of the descriptions."""

import json

import pytest

import lissom
from lissom.model.units import UNITS, unit_of, with_unit

#: How descriptions write units, by symbols.
WORDS = {
    "m": "metres",
    "Pa": "pascals",
    "s": "seconds",
    "kg": "kilograms",
    "N": "newtons",
    "N m": "newton metres",
}
WORDS |= {
    "kg/m³": "kg/m^3",
    "m/s²": "m/s^2",
    "m²": "square metres",
    "m³": "m^3",
    "Hz": "hertz",
    "rad": "radians",
}

OTHER_WORDS = {"square metres": "m^2"}


def described():
    """Descriptions of the numbers of all parts by their names."""
    found = {}
    for part in json.loads(lissom.Scene.schema())["definitions"].values():
        for name, field in part.get("properties", {}).items():
            if field.get("type") == "number":
                found.setdefault(name, []).append(field["description"])
    return found


@pytest.mark.parametrize("name", UNITS)
def test_descriptions_have_the_same_unit(name):
    word = WORDS.get(UNITS[name], UNITS[name])
    for text in described().get(name, []):
        assert word in text or OTHER_WORDS.get(word, word) in text, text


def test_the_table_is_of_what_there_is():
    assert len(described().keys() & UNITS.keys()) > len(UNITS) // 2


def test_units_are_those_of_paths():
    assert unit_of("segments[0].young_modulus") == unit_of("rod[0].segment[2].shear_modulus") == "Pa"
    assert unit_of("loads[0].force[2]") == "N"
    # Joints have stiffnesses of several units; a name alone is that of a function of the user.
    assert [unit_of(name) for name in ("links[0].joint.stiffness", "radius", "contacts[0].zzz")] == [""] * 3
    assert with_unit("segments[0].radius") == "segments[0].radius (m)"
    assert with_unit("young") == "young"
