"""The streamed sea beside the record of the buoy that it is made from, in the style of a notebook (`# %%` cells).

    python clients/python/examples/ndbc.py --url http://127.0.0.1:8080     # a server of preset ndbc-41010
    SWELLCAST_BIN=target/release/swellcast python clients/python/examples/ndbc.py

Prints Hs, Tp and the energy in bands, and saves ndbc.png. Needs the extra `plot`.
"""

# %% What is needed
from __future__ import annotations

import argparse
import asyncio
import math
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import swellcast
from swellcast.gather import dispersion_of, gather
from swellcast.spectrum import Spectrum

Floats = NDArray[np.float64]
PRESETS = Path(__file__).resolve().parents[3] / "src" / "scene" / "presets"
#: Bands whose energies are compared, Hz: swell, its slope, the peak, and the tail.
BANDS = np.array([0.055, 0.085, 0.115, 0.145, 0.175, 0.215, 0.265, 0.335, 0.495])


# %% The record: the preset names station and time, and the repository has the buoy's file
def record_of(preset: str) -> tuple[str, Floats, Floats]:
    """Time, frequencies (Hz) and densities (m^2/Hz) of the record that a preset is made from."""
    scene = tomllib.loads((PRESETS / f"{preset}.toml").read_text())
    station, time = scene["measured"]["station"], scene["measured"]["time"]
    for line in (PRESETS / "ndbc" / f"{station}.data_spec").read_text().splitlines():
        fields = line.split()
        if "{}-{}-{}T{}:{}".format(*fields[:5]) == time:
            # After the separation frequency stand pairs of density and (frequency).
            pairs = re.findall(r"([0-9.]+) \(([0-9.]+)\)", " ".join(fields[6:]))
            frequency, density = (np.array([float(pair[i]) for pair in pairs]) for i in (1, 0))
            return f"{station} at {time}", frequency[density < 999], density[density < 999]
    raise SystemExit(f"{station}.data_spec has no record of {time}")


def energy_between(frequency: Floats, density: Floats, edges: Floats) -> Floats:
    """Energy of the record in bands, m^2, as the server reads it: straight lines, beyond the ends to zero in one spacing."""
    ends = 2 * frequency[[0, -1]] - frequency[[1, -2]]
    frequency = np.concatenate([ends[:1], frequency, ends[1:]])
    density = np.concatenate([[0.0], density, [0.0]])
    fine = np.unique(np.concatenate([frequency, edges]))
    values = np.interp(fine, frequency, density, left=0.0, right=0.0)
    summed = np.concatenate([[0.0], np.cumsum(np.diff(fine) * (values[1:] + values[:-1]) / 2)])
    return np.diff(np.interp(edges, fine, summed))


# %% The sea: heights of every cascade for a while, transformed
async def watch(url: str, seconds: float) -> Spectrum:
    """The spectrum of a running sea."""
    async with swellcast.connect(url, playback=False) as ocean:
        print(f"{ocean.hello.scene} at {url}, {len(ocean.hello.layout.cascades)} cascades")
        found = await gather(ocean, seconds)
        return found.spectrum(await dispersion_of(ocean))


# %% Both, in numbers
def compare(frequency: Floats, density: Floats, sea: Spectrum) -> None:
    """Prints heights, periods, and ratios of energies."""
    total = float(energy_between(frequency, density, np.array([0.0, 1.0]))[0])
    print(f"Hs: buoy {4 * math.sqrt(total):.3f} m, streamed {sea.hs_m:.3f} m, ratio {sea.hs_m / (4 * math.sqrt(total)):.3f}")
    edges = np.concatenate([[1.5 * frequency[0] - 0.5 * frequency[1]], (frequency[1:] + frequency[:-1]) / 2, [0.5]])
    streamed = sea.density(edges)
    peaks = 1 / frequency[np.argmax(density)], 1 / frequency[np.argmax(streamed)]
    print(f"Tp: buoy {peaks[0]:.2f} s, streamed {peaks[1]:.2f} s (the buoy's bins)")
    print("   band, Hz        buoy, cm²  streamed, cm²  ratio   luck of the draw, 1 std")
    rows = zip(BANDS, BANDS[1:], energy_between(frequency, density, BANDS), sea.energy(BANDS), sea.scatter(BANDS), strict=False)
    for low, high, theirs, ours, scatter in rows:
        print(f"   {low:.3f} to {high:.3f}   {theirs * 1e4:9.1f}  {ours * 1e4:13.1f}  {ours / theirs:5.2f}   ± {scatter:.2f}")


# %% ... and as a picture
def picture(name: str, frequency: Floats, density: Floats, sea: Spectrum, path: Path) -> None:
    """Saves both spectra."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    edges = np.linspace(0.03, 0.5, 95)
    figure, axes = plt.subplots(figsize=(8, 4.5))
    axes.step(edges[:-1], sea.density(edges), where="post", label="streamed, by 2D transforms of its patches")
    axes.plot(frequency, density, "o-", markersize=3, label=f"NDBC {name}")
    axes.set(xlabel="frequency, Hz", ylabel="S(f), m²/Hz", title="One sea, measured and streamed")
    axes.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    print(path)


# %% All of it
def serve(binary: str) -> tuple[subprocess.Popen[str], str]:
    """Starts a server of the preset on a free port; gives it and its URL."""
    command = [binary, "serve", "--scene", "ndbc-41010", "--listen", "127.0.0.1:0"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert server.stdout is not None
    for line in server.stdout:
        if " at http://" in line:
            return server, line.split(" at ")[1].strip()
    raise SystemExit(f"{binary} does not start: status {server.wait()}")


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--url", help="of a server of preset ndbc-41010; without, SWELLCAST_BIN is started")
    parser.add_argument("--seconds", type=float, default=20.0, help="how long to watch (default 20)")
    parser.add_argument("--out", type=Path, default=Path("ndbc.png"), help="the picture (default ndbc.png)")
    asked = parser.parse_args()
    server, url = (None, asked.url) if asked.url else serve(os.environ.get("SWELLCAST_BIN", "target/release/swellcast"))
    try:
        name, frequency, density = record_of("ndbc-41010")
        sea = asyncio.run(watch(url, asked.seconds))
    finally:
        if server is not None:
            server.kill()
            server.wait()
    compare(frequency, density, sea)
    picture(name, frequency, density, sea, asked.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
