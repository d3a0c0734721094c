# SPDX-License-Identifier: LGPL-2.1-or-later
"""Laws by a formula, against closed forms, complex steps and the laws of the engine."""
import warnings

import numpy
import pytest
import stroma

POINTS = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1.2]])
CELLS = [[0, 1, 2, 3], [1, 2, 3, 4]]
FIBRE = numpy.array([1, 2, 2.0]) / 3


def gradients(count=20):
    random = numpy.random.default_rng(5)
    return numpy.eye(3) + 0.2 * random.normal(size=(count, 1, 3, 3))


def on(law, F):
    """The law at F, whatever mesh it was made for."""
    return law.density(F), law.stress(F), law.tangent(F)


CASES = {
    "neo-Hookean": ("mu/2 * (I1 - 3 - 2*log(J)) + la/2 * ln(J)^2",
                    lambda self, J, I1, I2, I4: 3.5 * (I1 - 3 - 2 * numpy.log(J)) + 15 * numpy.log(J) ** 2),
    "Mooney and Rivlin": ("3*(I1bar - 3) + 2*(I2bar - 3) + la/2 * (J - 1)^2",
                          lambda self, J, I1, I2, I4: 3 * (I1 * J ** (-2 / 3) - 3) + 2 * (I2 * J ** (-4 / 3) - 3) + 15 * (J - 1) ** 2),
    "fibres": ("mu/2*(I1bar - 3) + la/4*(J^2 - 1 - 2*log(J)) + (exp(2*(I4bar - 1)^2) - 1)/4",
               lambda self, J, I1, I2, I4: 3.5 * (I1 * J ** (-2 / 3) - 3) + 7.5 * (J ** 2 - 1 - 2 * numpy.log(J)) + (
                   numpy.exp(2 * (I4 * J ** (-2 / 3) - 1) ** 2) - 1) / 4),
    "functions": ("+sqrt(1 + I1) + sin(J) - cos(I1/9) + sinh(J/3) + cosh(I2/9) + tanh(I1/5) + 2^J + I1^J/9 - 1/(J + I1)",
                  lambda self, J, I1, I2, I4: numpy.sqrt(1 + I1) + numpy.sin(J) - numpy.cos(I1 / 9) + numpy.sinh(J / 3) +
                  numpy.cosh(I2 / 9) + numpy.tanh(I1 / 5) + 2 ** J + I1 ** J / 9 - 1 / (J + I1)),
}


@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_those_of_complex_steps(name):
    text, density = CASES[name]

    class ByHand(stroma.Law):
        def density(self, F):
            C = self.C(F)
            I1 = self.I1(F)
            return density(self, self.J(F), I1, (I1 ** 2 - numpy.einsum("...ij,...ij", C, C)) / 2, numpy.einsum("i,...ij,j", FIBRE, C, FIBRE))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # not all of them are without stress at rest
        law = stroma.FormulaLaw(POINTS, CELLS, text, fibre=[1, 2, 2], mu=7.0, la=30.0)
    F = gradients()
    (W, P, A), (W_by_hand, P_by_hand, A_by_hand) = on(law, F), on(ByHand(POINTS, CELLS), F)
    assert W == pytest.approx(W_by_hand, rel=1e-13)
    assert numpy.abs(P - P_by_hand).max() < 1e-13 * numpy.abs(P).max()
    assert numpy.abs(A - A_by_hand).max() < 1e-8 * numpy.abs(A).max(), "differences of stresses there, exact here"
    # exact: a complex step of the stress along one direction
    way = numpy.random.default_rng(1).normal(size=(3, 3))
    assert numpy.allclose(A, numpy.einsum("...ijkl->...klij", A), rtol=0, atol=1e-12 * numpy.abs(A).max())
    assert numpy.abs(numpy.einsum("...ijkl,kl", A, way)).max() > 0


def test_small_strains_are_those_of_hooke():
    """mu and K of the formula are the moduli of small strains: P = 2 mu dev(e) + K tr(e) I."""
    law = stroma.FormulaLaw(POINTS, CELLS, "mu/2*(I1bar - 3) + K/2*(J - 1)^2", mu=7.0, K=30.0)
    e = numpy.array([[1, 2, 0], [2, -3, 1], [0, 1, 4]])
    A = law.tangent(numpy.broadcast_to(numpy.eye(3), (2, 1, 3, 3)).copy())[0, 0]
    expected = 2 * 7 * (e - numpy.trace(e) / 3 * numpy.eye(3)) + 30 * numpy.trace(e) * numpy.eye(3)
    assert numpy.einsum("ijkl,kl", A, e) == pytest.approx(expected, abs=1e-11)


def scene(field):
    root = stroma.Node("root", dt=0.01, gravity=(0, -9.81, 0))
    root.add("EulerImplicitSolver", newtonIterations=20)
    root.add("SparseLDLSolver")
    root.add("MeshTopology", name="mesh", position=POINTS, tetrahedra=CELLS)
    root.add("MechanicalObject", name="dofs")
    root.add("UniformMass", totalMass=2)
    root.add("FixedProjectiveConstraint", indices=[0, 1, 2])
    root.add(field) if isinstance(field, stroma.ForceField) else root.add("TetrahedronHyperelasticityFEMForceField", **field)
    return stroma.load(root)


def test_it_moves_as_the_law_of_the_engine():
    mu, la = 50.0, 200.0
    cells = scene({"materialName": "NeoHookean", "ParameterSet": [mu, la]})["/mesh"].tetrahedra
    law = stroma.FormulaLaw(POINTS, cells, "mu/2 * (I1 - 3) - mu*log(J) + la/2 * log(J)^2", mu=mu, la=la)
    mine, theirs = scene(law), scene({"materialName": "NeoHookean", "ParameterSet": [mu, la]})
    mine.run(15), theirs.run(15)
    moved = numpy.abs(theirs.state().x - POINTS).max()
    assert moved > 0.05
    assert numpy.abs(mine.state().x - theirs.state().x).max() < 1e-6 * moved
    assert law.check(mine.state().x)["stiffness"] < 1e-6


def test_parameters_of_each_cell():
    one = stroma.FormulaLaw(POINTS, CELLS, "mu/2*(I1 - 3 - 2*log(J))", mu=[1.0, 3.0])
    F = gradients(2)
    alone = [stroma.FormulaLaw(POINTS, CELLS, "mu/2*(I1 - 3 - 2*log(J))", mu=mu).stress(F)[i] for i, mu in enumerate((1.0, 3.0))]
    assert numpy.array_equal(one.stress(F), alone)
    with pytest.raises(ValueError, match="one for each of 2 cells"):
        stroma.FormulaLaw(POINTS, CELLS, "mu*I1", mu=[1.0, 2.0, 3.0])


@pytest.mark.parametrize("text, words", [
    ("mu/2*(I1 - 3", "cannot be read"), ("mu*I1baar", "'I1baar', which is neither.*did you mean 'I1bar'"), ("I4 + mu", "'I4', which is neither"),
    ("__import__('os')", "no function"), ("I1.real", "what is none"), ("sqr(I1)", "no function 'sqr'.*did you mean 'sqrt'"),
    ("[I1]", "what is none"), ("I1 if J else 2", "what is none"), ("'a'", "what is none"), ("True", "what is none"), ("", "cannot be read"),
])
def test_what_is_no_formula(text, words):
    with pytest.raises(stroma.SceneError, match=words) as caught:
        stroma.FormulaLaw(POINTS, CELLS, text, mu=1.0)
    assert caught.value.file == __file__


def test_what_a_parameter_is_not_called_and_a_stress_at_rest():
    with pytest.raises(stroma.SceneError, match="called J"):
        stroma.FormulaLaw(POINTS, CELLS, "J", J=1.0)
    with pytest.warns(UserWarning, match="stress at rest, 2 Pa"):
        stroma.FormulaLaw(POINTS, CELLS, "mu*I1", mu=1.0)
