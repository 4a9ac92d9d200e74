"""Draws a running sea: `swellcast-plot --url URL --out DIR` saves a height map, a spectrum and a series as PNG."""

from __future__ import annotations

import argparse
import asyncio
import logging
import sys
from pathlib import Path
from typing import Any

import numpy as np

from .errors import SwellcastError
from .gather import Gathered, dispersion_of, gather
from .http import Statistics
from .ocean import connect
from .spectrum import Dispersion, bins


def draw(found: Gathered, dispersion: Dispersion, told: Statistics, name: str, where: tuple[float, float], out: Path) -> None:
    """Saves the three pictures and prints heights and periods."""
    plt = _pyplot()
    out.mkdir(parents=True, exist_ok=True)
    edges = bins()
    spectrum = found.spectrum(dispersion)
    hs, tp = spectrum.hs_m, spectrum.peak_s(edges)
    frames = min(cascade.frames for cascade in found.energies.values())
    server_tp = "-" if told.tp_s is None else f"{told.tp_s:.2f} s"
    print(f"{name}: Hs {hs:.3f} m (4 std of the heights of {frames} frames; the server says {told.hs_m:.3f} m)")
    print(f"{name}: Tp {tp:.2f} s (of the streamed spectrum; the server says {server_tp})")

    side, heights = found.map(512)
    figure, axes = plt.subplots(figsize=(7, 6))
    image = axes.imshow(heights, extent=(0, side, side, 0), cmap="viridis", vmin=-hs, vmax=hs)
    figure.colorbar(image, label="height, m")
    axes.set(title=f"{name}: height over rest positions", xlabel="x (east), m", ylabel="z (south), m")
    _save(plt, figure, out / "height.png")

    figure, axes = plt.subplots(figsize=(7, 4.5))
    density = spectrum.density(edges)
    shown = density > density.max() * 1e-6
    axes.step(edges[:-1][shown], density[shown], where="post")
    axes.axvline(1 / tp, color="grey", linestyle=":", label=f"Tp {tp:.2f} s")
    axes.set(xscale="log", yscale="log", xlabel="frequency, Hz", ylabel="S(f), m²/Hz")
    axes.set_title(f"{name}: Hs {hs:.2f} m, {frames} frames")
    axes.legend()
    _save(plt, figure, out / "spectrum.png")

    times, series = found.series()
    figure, axes = plt.subplots(figsize=(9, 3))
    axes.plot(times - times[0], series)
    axes.set(xlabel=f"seconds after {times[0]:.1f} s", ylabel="height, m", ylim=(-hs, hs))
    axes.set_title(f"{name}: the water that rests at x {where[0]:g} m, z {where[1]:g} m")
    _save(plt, figure, out / "series.png")


async def plot(url: str, out: Path, seconds: float, where: tuple[float, float]) -> None:
    """Gathers and draws."""
    _pyplot()  # what is missing is missed before, not after
    async with connect(url, playback=False) as ocean:
        found = await gather(ocean, seconds, where)
        dispersion, told, name = await dispersion_of(ocean), await ocean.statistics(), ocean.hello.scene
    draw(found, dispersion, told, name, where, out)


def _save(plt: Any, figure: Any, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    plt.close(figure)
    print(path)


def _pyplot() -> Any:
    try:
        import matplotlib
    except ImportError:
        raise SwellcastError("matplotlib is missing: pip install 'swellcast[plot]'") from None
    matplotlib.use("Agg")
    import matplotlib.pyplot

    return matplotlib.pyplot


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser("swellcast-plot", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--url", required=True, help="of the server, like http://127.0.0.1:8080")
    parser.add_argument("--out", required=True, type=Path, help="folder for the pictures")
    parser.add_argument("--seconds", type=float, default=20.0, help="how long to watch (default 20)")
    parser.add_argument("--at", default="0,0", help="x,z of the point of the series, metres (default 0,0)")
    asked = parser.parse_args()
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    try:
        x, z = (float(metres) for metres in asked.at.split(","))
        if not (np.isfinite([x, z, asked.seconds]).all() and asked.seconds > 0):
            raise ValueError("--at and --seconds must be finite, seconds above 0")
        asyncio.run(plot(asked.url, asked.out, asked.seconds, (x, z)))
    except (SwellcastError, ValueError, TimeoutError, OSError) as error:
        print(f"swellcast-plot: {error or 'no frame in time'}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
