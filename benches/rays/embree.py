#!/usr/bin/env python3
"""Measures Embree on meshes and rays that goblet has written, and prints the same table as goblet.

    cargo bench --bench rays -- --write-rays FOLDER
    pip install numpy embreex
    python3 benches/rays/embree.py FOLDER [--turns N] [--robust]

One thread traces one ray at a time. Both programs count the hits of the same rays: they may differ by a few
in a million, for rays along edges and rays that begin on a surface.
"""

import argparse
import importlib.metadata
import statistics
import time
from pathlib import Path

import numpy
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

SETS = ("random", "eye", "photon")
QUESTIONS = ("INTERSECT", "OCCLUDED")


class Case:
    """A set of rays in a scene, and how long it took for each question: CPU and wall seconds."""

    def __init__(self, name, rays_name, triangles, scene, rays):
        self.name, self.rays_name, self.triangles, self.scene = name, rays_name, triangles, scene
        self.origins = numpy.ascontiguousarray(rays[:, 0:3])
        self.t_max = numpy.ascontiguousarray(rays[:, 3])
        self.directions = numpy.ascontiguousarray(rays[:, 4:7])
        self.times = {question: [] for question in QUESTIONS}
        self.hits = {}

    def trace(self, question):
        cpu, wall = time.process_time(), time.perf_counter()
        found = self.scene.run(self.origins, self.directions, dists=self.t_max, query=question)
        self.times[question].append((time.process_time() - cpu, time.perf_counter() - wall))
        self.hits[question] = int(numpy.count_nonzero(found != -1))

    def row(self):
        cells = [self.name, self.triangles, self.rays_name]
        spread = 0.0
        for question in QUESTIONS:
            for seconds in zip(*self.times[question]):
                cells.append(f"{len(self.origins) * 1e-6 / statistics.median(seconds):.2f}")
            cpu = [times[0] for times in self.times[question]]
            spread = max(spread, (max(cpu) - min(cpu)) / statistics.median(cpu))
        nearest, occluded = (self.hits[question] for question in QUESTIONS)
        hits = str(nearest) if nearest == occluded else f"{nearest}, any {occluded}"
        return "| " + " | ".join(map(str, [*cells, f"{100 * spread:.0f} %", hits])) + " |"


def load(folder, robust):
    """The cases of a folder, with one Embree scene for each mesh."""
    cases = []
    paths = sorted(folder.glob("*.triangles"), key=lambda path: path.stat().st_size)
    for path in paths:
        corners = numpy.fromfile(path, "<f4").astype(numpy.float32).reshape(-1, 3, 3)
        scene = EmbreeScene(robust=robust)
        TriangleMesh(scene, corners)
        for rays_name in SETS:
            rays_path = path.with_name(f"{path.stem}.{rays_name}.rays")
            if rays_path.exists():
                rays = numpy.fromfile(rays_path, "<f4").astype(numpy.float32).reshape(-1, 8)
                cases.append(Case(path.stem, rays_name, len(corners), scene, rays))
    return cases


def main():
    parser = argparse.ArgumentParser(description="Measures Embree on what goblet's benchmark of rays has written.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--robust", action="store_true", help="Embree's watertight intersections")
    arguments = parser.parse_args()
    cases = load(arguments.folder, arguments.robust)
    # The first query builds the hierarchy.
    for turn in range(arguments.turns + 1):
        for case in cases if turn % 2 else reversed(cases):
            for question in QUESTIONS:
                case.trace(question)
        if turn == 0:
            for case in cases:
                case.times = {question: [] for question in QUESTIONS}
    print(f"embreex {importlib.metadata.version('embreex')}, {'robust, ' if arguments.robust else ''}one thread")
    print(f"medians of {arguments.turns} turns\n")
    print("| scene | triangles | rays | nearest Mray/CPU s | nearest Mray/s | any Mray/CPU s | any Mray/s | spread | hits |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for case in cases:
        print(case.row())


if __name__ == "__main__":
    main()
