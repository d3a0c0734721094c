#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Stroma's multigrid and factors against those of libraries, on matrices of scenes/benchmarks/statics.xml that Stroma writes.

    apt-get install --no-install-recommends python3-petsc4py-real3.18 python3-scipy
    PYTHONPATH=build/release/python /usr/bin/python3 tools/bench/library_solvers.py --body cube --cells 21 --ratio 0.3 --rounds 3

A block of linear tetrahedra, held at one face, under its weight: a cube, or a beam of 20:1 with --cells cells across. The matrix has no rows of
held nodes. Libraries, all through PETSc: hypre's BoomerAMG and PETSc's GAMG as preconditioners of conjugate gradients, MUMPS and
CHOLMOD (supernodes on the BLAS). Processor seconds on one thread, least of --rounds, in turns. Solves stop at |b - A x| <= --tolerance |b|;
the residual in the table is computed here. Round-off keeps that of a slender beam above 1e-8: it needs --tolerance 1e-7.

Set-up is from an assembled matrix to the first application, with the analysis of the pattern. Stroma assembles within its solves: that time is
measured by a solve of one iteration with the diagonal blocks, and subtracted. Set-up of its multigrid is likewise that of one iteration."""
import argparse
import os
import sys
import tempfile
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before the libraries are opened
os.environ.setdefault("OMP_NUM_THREADS", "1")
PETSC = "/usr/lib/petscdir/petsc3.18/x86_64-linux-gnu-real/lib/python3/dist-packages"  # where Debian has petsc4py
if os.path.isdir(PETSC):
    sys.path.insert(0, PETSC)

import numpy  # noqa: E402
import petsc4py  # noqa: E402
import scipy.sparse  # noqa: E402

petsc4py.init(["library_solvers"])
from petsc4py import PETSc  # noqa: E402

import stroma  # noqa: E402

SCENE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "benchmarks", "statics.xml")
STATIC = '<StaticSolver name="solver"/>'
PCG = '<PCGLinearSolver name="linear" preconditioner="{}" template="CompressedRowSparseMatrix" tolerance="{}" iterations="{}"/>'
FACTORS = '<SparseLDLSolver name="linear" {}/>'
BOOMER = {"pc_type": "hypre", "pc_hypre_type": "boomeramg", "pc_hypre_boomeramg_strong_threshold": 0.5,
          "pc_hypre_boomeramg_coarsen_type": "HMIS", "pc_hypre_boomeramg_interp_type": "ext+i", "pc_hypre_boomeramg_P_max": 4,
          "pc_hypre_boomeramg_nodal_coarsen": 4}
GAMG = {"pc_type": "gamg", "pc_gamg_threshold": 0, "pc_gamg_square_graph": 10, "mg_levels_ksp_type": "chebyshev",
        "mg_levels_pc_type": "jacobi", "mg_levels_ksp_max_it": 2}
# name: options, rigid-body modes
ITERATIVE = {
    "BoomerAMG, one aggressive level": ({**BOOMER, "pc_hypre_boomeramg_agg_nl": 1}, False),
    "BoomerAMG with rigid-body modes": ({**BOOMER, "pc_hypre_boomeramg_vec_interp_variant": 2}, True),
    "GAMG with rigid-body modes": (GAMG, True),
}
DIRECT = {"MUMPS": "mumps", "CHOLMOD": "cholmod"}


def seconds(work):
    """Processor time, and what the work returns."""
    begin = time.process_time()
    result = work()
    return time.process_time() - begin, result


class Body:
    """The block, its matrix and its load, and Stroma's solvers of it."""

    def __init__(self, body, cells, ratio, tolerance, folder):
        self.tolerance = tolerance
        across, along = cells + 1, 20 * cells + 1
        shape = (across,) * 3 if body == "cube" else (along, across, across)
        self.settings = {"/block/grid.n": " ".join(map(str, shape)), "/block/cells/fem.method": "small",
                         "/block/cells/fem.poissonRatio": ratio}
        if body != "cube":
            self.settings.update({"/block/grid.max": "2.8 0.14 0.14", "/block/cells/fem.youngModulus": 3e9})
        self.folder, self.tetrahedra = folder, 5 * cells**3 * (1 if body == "cube" else 20)
        simulation = self.load("")
        places = simulation.state().x
        free = numpy.flatnonzero(places[:, 0] > 1e-6)
        rows = (3 * free[:, None] + numpy.arange(3)).ravel()
        self.matrix = (-simulation.matrix()).tocsr()[rows][:, rows].tobsr((3, 3))
        self.matrix.sort_indices()
        self.nodes, self.places, self.b = free, places[free], simulation.force()[free].ravel()

    def load(self, solver, **more):
        scene = os.path.join(self.folder, "scene.xml")
        with open(SCENE, encoding="utf-8") as source, open(scene, "w", encoding="utf-8") as out:
            text = source.read()
            assert STATIC in text
            out.write(text.replace(STATIC, STATIC + solver))
        return stroma.load(scene, set={**self.settings, **more}, observers=False, quiet=True)

    def solve(self, solver):
        """Processor seconds of assembly, set-up and solve, and the solution."""
        simulation = self.load(solver)
        force = simulation.force()
        begin = time.process_time()
        try:
            found = simulation.solve(force)
        except stroma.StromaError:
            if 'iterations="1"' in solver:
                return time.process_time() - begin, None
            raise
        return time.process_time() - begin, found[self.nodes].ravel()

    def iterations(self, solver):
        """Of a static step's first solve, in which a linear body is at rest already."""
        simulation = self.load(solver, **{"/block/solver.newton_iterations": 1})
        simulation.step()
        return len(simulation["/block/linear"].graph)

    def residual(self, x):
        return numpy.linalg.norm(self.b - self.matrix @ x) / numpy.linalg.norm(self.b)


def by_multigrid(body):
    """Assembly, assembly with set-up, and the whole: what has to be subtracted when all rounds are over."""
    assembly = body.solve(PCG.format("block_jacobi", body.tolerance, 1))[0]
    setup = body.solve(PCG.format("multigrid", body.tolerance, 1))[0]
    whole, x = body.solve(PCG.format("multigrid", body.tolerance, 3000))
    return (assembly, setup, whole), x, None


def by_factors(body, attributes):
    assembly = body.solve(PCG.format("block_jacobi", body.tolerance, 1))[0]
    whole, x = body.solve(FACTORS.format(attributes))
    return (assembly, whole, whole), x, ""


def vectors(matrix, b):
    x, right = matrix.createVecs()
    right.array[:] = b
    return x, right


def options_of(prefix, values):
    for name, value in values.items():
        PETSc.Options()[prefix + name] = value


def by_iterations(body, name, number):
    options, modes = ITERATIVE[name]
    prefix = f"s{number}_"
    options_of(prefix, options)
    blocks = body.matrix
    matrix = PETSc.Mat().createBAIJ(blocks.shape, 3, csr=(blocks.indptr, blocks.indices, blocks.data))
    matrix.convert("aij")  # the only kind that both take
    matrix.setBlockSize(3)
    matrix.setOption(PETSc.Mat.Option.SPD, True)
    if modes:
        places = PETSc.Vec().createWithArray(numpy.ascontiguousarray(body.places).ravel(), bsize=3)
        matrix.setNearNullSpace(PETSc.NullSpace().createRigidBody(places))
    solver = PETSc.KSP().create()
    solver.setOptionsPrefix(prefix)
    solver.setOperators(matrix)
    solver.setType("cg")
    solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
    solver.setTolerances(rtol=body.tolerance, atol=0, max_it=3000)
    solver.setFromOptions()
    x, right = vectors(matrix, body.b)
    setup = seconds(solver.setUp)[0] + seconds(solver.setUpOnBlocks)[0]
    solve = seconds(lambda: solver.solve(right, x))[0]
    found = x.array.copy(), solver.getIterationNumber()
    for part in (solver, matrix, x, right):
        part.destroy()
    return (0., setup, setup + solve), *found


def by_library(body, kind, number):
    upper = scipy.sparse.triu(body.matrix.tocsr(), format="csr")
    matrix = PETSc.Mat().createSBAIJ(upper.shape, 1, csr=(upper.indptr, upper.indices, upper.data))
    matrix.setOption(PETSc.Mat.Option.SPD, True)
    solver = PETSc.KSP().create()
    solver.setOptionsPrefix(f"d{number}_")
    solver.setOperators(matrix)
    solver.setType("preonly")
    inverse = solver.getPC()
    inverse.setType("cholesky")
    inverse.setFactorSolverType(kind)
    if kind == "mumps":
        options_of(f"d{number}_", {"mat_mumps_icntl_7": 5})  # METIS
    solver.setFromOptions()
    x, right = vectors(matrix, body.b)
    setup = seconds(solver.setUp)[0]
    solve = seconds(lambda: solver.solve(right, x))[0]
    found = x.array.copy()
    for part in (solver, matrix, x, right):
        part.destroy()
    return (0., setup, setup + solve), found, ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--body", choices=("cube", "beam"), default="cube")
    parser.add_argument("--cells", type=int, default=21, help="across, of five tetrahedra each")
    parser.add_argument("--ratio", type=float, default=0.3, help="Poisson's ratio")
    parser.add_argument("--tolerance", type=float, default=1e-8, help="of the residual")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", default="", help="methods with this in their names")
    asked = parser.parse_args()
    stroma.set_threads(1)
    with tempfile.TemporaryDirectory() as folder:
        body = Body(asked.body, asked.cells, asked.ratio, asked.tolerance, folder)
        methods = {"Stroma, multigrid": lambda _: by_multigrid(body)}
        methods.update({name: lambda k, name=name: by_iterations(body, name, k) for name in ITERATIVE})
        methods["Stroma, factors"] = lambda _: by_factors(body, "")
        methods["Stroma, factors in double precision"] = lambda _: by_factors(body, 'precision="double"')
        methods.update({name: lambda k, kind=kind: by_library(body, kind, k) for name, kind in DIRECT.items()})
        methods = {name: work for name, work in methods.items() if asked.only in name}
        found = {name: [] for name in methods}
        for k in range(asked.rounds):
            for name, work in methods.items():
                found[name].append(work(k))
        its = body.iterations(PCG.format("multigrid", body.tolerance, 3000))
        print(f"{asked.body}, {body.tetrahedra} tetrahedra, {len(body.nodes)} free nodes, Poisson's ratio {asked.ratio}")
        print("| | iterations | set-up [s] | solve [s] | together [s] | residual |\n|---|---|---|---|---|---|")
        for name, rows in found.items():
            assembly, setup, whole = (min(row[0][k] for row in rows) for k in range(3))
            _, x, count = rows[0]
            print(f"| {name} | {its if count is None else count} | {setup - assembly:.3f} | {whole - setup:.3f} | {whole - assembly:.3f} | "
                  f"{body.residual(x):.1e} |")


if __name__ == "__main__":
    main()
