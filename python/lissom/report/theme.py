"""Colours and layout that all figures share; readable on light and on dark ground."""

from __future__ import annotations

from typing import Any

BLUE, ORANGE, GREEN, PURPLE, RED, CYAN, GREY = (
    "#3a7bd5",
    "#e8833a",
    "#2ca25f",
    "#9467d1",
    "#d9485f",
    "#17a2b8",
    "#808994",
)

#: Of moments, beside forces in red.
MAGENTA = "#c2479a"

#: Of tendons.
GOLD = "#c9981a"

#: One colour for each part of the energy, in every figure.
ENERGY_COLOURS = {
    "kinetic": BLUE,
    "elastic": ORANGE,
    "gravitational": GREEN,
    "loads": PURPLE,
    "dissipated": RED,
    "work": CYAN,
    "total": GREY,
}

#: Colours of successive curves without a meaning of their own.
SERIES = (BLUE, ORANGE, GREEN, PURPLE, RED, CYAN, GREY)

#: From the base of a rod to its tip.
ROD_SCALE = [[0.0, "#2b3a8c"], [0.45, "#2f8fc4"], [0.75, "#43c6a8"], [1.0, "#f4d35e"]]

GRID = "rgba(128, 136, 148, 0.25)"
#: Lines in space are not blended with what is behind the figure, so that they need a colour of their own.
SPACE_GRID = "#8b939f"
FAINT = "rgba(128, 136, 148, 0.55)"
BUTTON = "rgba(128, 136, 148, 0.18)"
CLEAR = "rgba(0, 0, 0, 0)"


def layout(height: int = 420, **changes: Any) -> dict[str, Any]:
    """Keyword arguments for ``figure.update_layout``."""
    base: dict[str, Any] = {
        "template": "none",
        "height": height,
        "paper_bgcolor": CLEAR,
        "plot_bgcolor": CLEAR,
        "margin": {"l": 75, "r": 20, "t": 30, "b": 55},
        "font": {"family": "system-ui, -apple-system, 'Segoe UI', Roboto, Arial, sans-serif", "size": 13},
        "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0, "xanchor": "left"},
        "hovermode": "closest",
        "modebar": {"bgcolor": CLEAR, "color": FAINT, "activecolor": BLUE},
        "colorway": list(SERIES),
    }
    return base | changes


def axis(title: str, **changes: Any) -> dict[str, Any]:
    """An axis of a plane figure."""
    base: dict[str, Any] = {
        "title": {"text": title},
        "gridcolor": GRID,
        "zerolinecolor": FAINT,
        "linecolor": FAINT,
        "ticks": "outside",
        "tickcolor": FAINT,
        "exponentformat": "power",
        "automargin": True,
    }
    return base | changes


def player(
    frames: list[Any],
    labels: list[str],
    frame_milliseconds: float,
    label: tuple[str, str] = ("t = ", " s"),
    y: float = 0.0,
    active: int = 0,
) -> dict[str, Any]:
    """Play and pause buttons and a slider for an animated figure; ``label`` stands around those of frames.

    The slider stands at the frame ``active``.
    """
    pace = {"frame": {"duration": frame_milliseconds, "redraw": True}, "transition": {"duration": 0}}
    still = {"frame": {"duration": 0, "redraw": True}, "transition": {"duration": 0}, "mode": "immediate"}
    buttons = [
        {
            "label": "▶ Play",
            "method": "animate",
            "args": [None, pace | {"fromcurrent": True, "mode": "immediate"}],
        },
        {"label": "❚❚ Pause", "method": "animate", "args": [[None], still]},
    ]
    steps = [
        {"label": label, "method": "animate", "args": [[frame.name], still]}
        for frame, label in zip(frames, labels, strict=True)
    ]
    return {
        "updatemenus": [
            {
                "type": "buttons",
                "direction": "right",
                "buttons": buttons,
                "showactive": False,
                "x": 0,
                "xanchor": "left",
                "y": y,
                "yanchor": "top",
                "pad": {"t": 18},
                "bgcolor": BUTTON,
                "bordercolor": FAINT,
            }
        ],
        "sliders": [
            {
                "active": active,
                "steps": steps,
                "x": 0.22,
                "len": 0.78,
                "y": y,
                "yanchor": "top",
                "pad": {"t": 4},
                "currentvalue": {"prefix": label[0], "suffix": label[1], "xanchor": "left"},
                "ticklen": 0,
                "minorticklen": 0,
                "bgcolor": BUTTON,
                "bordercolor": FAINT,
            }
        ],
    }
