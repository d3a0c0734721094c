// SPDX-License-Identifier: LGPL-2.1-or-later
// Prony viscosity: the modulus over time and over frequency against closed forms, orders in the time step, and a
// history that belongs to the state.
#include <complex>
#include <numbers>

#include "components/hyperelasticity/prony_series.h"
#include "tests/hyperelasticity/viscous_bodies.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

TEST(ViscousLaw, StepRelaxation) {
  const double times[4] = {0, 0.01, 0.1, 1}, published[4] = {770, 690.737, 466.729, 337.097}, h = 0.002;
  for (const bool cube : {false, true})
    for (const std::string& word : updates) {
      Driven body(law + prony + update(word), cube);
      Mat3 f = Mat3::Identity();
      f(0, 1) = 0.2;
      body.startAt(f);
      int sample = 1;
      for (int n = 1; n <= 500; ++n) {
        const double g = body.shearModulus(n * h, 0.2, 0.2);
        // a stress that does not change: the exponential update is exact, the backward one a geometric series
        double expected = modulus(n * h);
        if (word == "backward") {
          expected = g0;
          for (int i = 0; i < 2; ++i) expected -= g0 * alpha[i] * (1 - std::pow(tau[i] / (h + tau[i]), n));
        }
        ASSERT_NEAR(g, expected, 1e-9 * g0) << word << " step " << n;
        if (std::abs(n * h - times[sample]) > 1e-9) continue;
        EXPECT_NEAR(g, published[sample], word == "backward" ? 6 : 6e-4) << word << " t = " << times[sample];
        if (!cube) std::printf("%-12s G(%.2f s) = %.4f Pa, closed form %.4f\n", word.c_str(), n * h, g, modulus(n * h));
        ++sample;
      }
      EXPECT_EQ(sample, 4);
    }
}

/// Each point of a hexahedron has its own past: under any shape that is held, all stresses relax by the same share. With
/// the dilatation of the points: viscosity has no mean one, and the elastic body to compare with must not take it.
TEST(ViscousLaw, EveryPointOfAHexahedronRelaxes) {
  for (const LawCase& l : lawCases()) {
    SCOPED_TRACE(l.name);
    FieldUnderTest t(block(l.attributes + prony + update("exponential")), hexahedral),
        elastic(block(l.attributes + " dilatation=\"local\""), hexahedral);
    t.deform(0.05), elastic.deform(0.05);
    copy(t.x, t.system().x);
    t.field().reset();
    const Vector unrelaxed = elastic.force();
    for (const double time : {0.01, 0.1, 1.}) {
      t.field().setTime(time);
      Vector expected(unrelaxed.count());
      axpy(modulus(time) / g0, unrelaxed, expected);
      EXPECT_LT(relativeDifference(t.force(), expected), 1e-12) << time;
      dynamic_cast<History&>(t.field()).stepEnded(time);
      EXPECT_LT(relativeDifference(t.force(), expected), 1e-12) << time << ", ended";
    }
    EXPECT_EQ(dynamic_cast<History&>(t.field()).history().size(), 24u * 8 * 3 * 6)
        << "24 cells, 8 points, 2 terms and S_h";
  }
}

/// Against the Prony integral of a sine that begins at 0.
TEST(ViscousLaw, OrderInTheTimeStep) {
  const double w = 7, end = 1, size = 0.1;
  double expected = size * g0 * std::sin(w * end);
  for (int i = 0; i < 2; ++i) {
    const double z = w * tau[i];
    expected -=
        size * g0 * alpha[i] / (1 + z * z) * (std::sin(w * end) - z * std::cos(w * end) + z * std::exp(-end / tau[i]));
  }
  for (const std::string& word : updates) {
    std::vector<double> errors;
    for (int steps : {50, 100, 200, 400, 800}) {
      Driven body(law + prony + update(word));
      double stress = 0;
      for (int n = 1; n <= steps; ++n)
        stress = body.shearModulus(n * end / steps, size * std::sin(w * n * end / steps));
      errors.push_back(std::abs(stress - expected) / expected);
    }
    const double order = std::log2(errors[3] / errors[4]);
    std::printf("%-12s errors %.2e %.2e %.2e %.2e %.2e, order %.3f\n", word.c_str(), errors[0], errors[1], errors[2],
                errors[3], errors[4], order);
    EXPECT_NEAR(order, word == "backward" ? 1 : 2, 0.05) << word;
  }
}

/// The complex modulus, taken from a steady oscillation: that of the recursion to round-off, that of the series as the
/// step goes to zero.
TEST(ViscousLaw, FrequencySweep) {
  using Complex = std::complex<double>;
  constexpr int steps = 200;
  for (const std::string& word : updates)
    for (double w : {0.3, 1., 3., 10., 30., 100., 300.}) {
      const double h = 2 * std::numbers::pi / w / steps;
      Complex series = g0, recursion = g0;
      const Complex back = std::exp(Complex(0, -w * h));
      for (int i = 0; i < 2; ++i) {
        series -= g0 * alpha[i] / (1. + Complex(0, w * tau[i]));
        const PronyStep s =
            pronyStep(word == "backward" ? PronyUpdate::backward : PronyUpdate::exponential, alpha[i], tau[i], h);
        recursion -= g0 * (s.now + s.before * back) / (1. - s.kept * back);
      }
      Driven body(law + prony + update(word));
      const int settle = steps * (2 + int(25 * tau[0] / (steps * h)));
      Complex measured = 0;
      for (int n = 1; n <= settle + steps; ++n) {
        const double stress = body.shearModulus(n * h, 1e-3 * std::cos(w * n * h), 1e-3);
        if (n > settle) measured += 2. / steps * stress * std::exp(Complex(0, -w * n * h));
      }
      EXPECT_LT(std::abs(measured - recursion), 1e-6 * std::abs(series)) << word << " " << w;
      EXPECT_LT(std::abs(measured - series) / std::abs(series), word == "backward" ? 0.02 : 1e-4) << word << " " << w;
      if (word == "exponential")
        std::printf("w = %5.1f /s: G' = %8.3f G'' = %8.3f Pa, closed form %8.3f %8.3f\n", w, measured.real(),
                    measured.imag(), series.real(), series.imag());
    }
}

/// A cube under a constant pull: the creep compliance of a standard linear solid, in units of the elastic displacement.
TEST(ViscousLaw, Creep) {
  const double share = 0.4, time = 0.2, h = 0.001;
  const auto pulled = [](const std::string& viscosity) {
    return simulationFromText(
        "<Node name=\"root\" dt=\"0.001\" gravity=\"0 0 0\"><StaticSolver "
        "relative_residual_tolerance_threshold=\"1e-10\"/><SparseLDLSolver/><RegularGridTopology name=\"grid\" "
        "n=\"2 2 2\" min=\"0 0 0\" max=\"1 1 1\"/><Node name=\"b\"><TetrahedronSetTopologyContainer name=\"tets\"/>"
        "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@tets\"/><MechanicalObject/>"
        "<UniformMass totalMass=\"1\"/><" +
        tetrahedral + " materialName=\"StVenantKirchhoff\" ParameterSet=\"500 0\"" + viscosity +
        "/><FixedProjectiveConstraint indices=\"0 1 2 3\"/>"
        "<ConstantForceField indices=\"4 5 6 7\" totalForce=\"0 0 0.001\"/></Node></Node>");
  };
  Simulation elastic = pulled("");
  elastic.step();
  const double unit = elastic.systems()[0]->x[7].z() - 1;
  ASSERT_GT(unit, 1e-8);
  for (const std::string& word : updates) {
    Simulation simulation = pulled(" viscous=\"true\" ParameterAlpha=\"0.4\" ParameterTau=\"0.2\"" + update(word));
    // the recursion of a scalar: 1 = strain - gamma
    double gamma = 0, strain = 0, worst = 0;
    const PronyStep s =
        pronyStep(word == "backward" ? PronyUpdate::backward : PronyUpdate::exponential, share, time, h);
    for (int n = 1; n <= 600; ++n) {
      ASSERT_FALSE(simulation.step().diverged);
      const double held = s.kept * gamma + s.before * strain;
      strain = (1 + held) / (1 - s.now);
      gamma = s.now * strain + held;
      const double found = (simulation.systems()[0]->x[7].z() - 1) / unit;
      ASSERT_NEAR(found / strain, 1, 1e-5) << word << " " << n;  // what strains of 1e-6 have of a square
      const double t = n * h, relaxed = 1 - share;
      worst = std::max(worst, std::abs(found / (1 + share / relaxed * -std::expm1(-t * relaxed / time)) - 1));
    }
    EXPECT_LT(worst, 3e-3) << word;
    std::printf("%-12s creep within %.1e of the closed form\n", word.c_str(), worst);
  }
}

TEST(ViscousLaw, TurningWithTheBodyChangesNothing) {
  for (const LawCase& l : lawCases())
    for (const std::string& word : updates)
      for (const bool cube : {false, true}) {
        Driven still(l.attributes + prony + update(word), cube), turning(l.attributes + prony + update(word), cube);
        for (int n = 1; n <= 20; ++n) {
          const double t = 0.01 * n;
          Mat3 f = Mat3::Identity();
          f(0, 1) = 0.3 * std::sin(20 * t), f(2, 2) = 1 + t, f(1, 0) = -t, f(1, 2) = 0.2 * t;
          const Mat3 q = Eigen::AngleAxisd(13 * t, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
          const Mat3 p = still.step(t, f), turned = turning.step(t, q * f);
          ASSERT_LT((q * p - turned).norm(), 1e-11 * p.norm()) << l.name << " " << n;
        }
      }
}

// ---- the tangent, and the history as state ----

const std::vector<std::string> forms{"", " discretization=\"standard\"", " matrixRegularization=\"true\"",
                                     " projectedTangent=\"true\""};

TEST(ViscousLaw, TangentIsTheForcesDerivative) {
  for (const LawCase& l : lawCases())
    for (const bool cubes : {false, true})
      for (const std::string& form : forms) {
        SCOPED_TRACE(l.name + form + (cubes ? " hexahedra" : ""));
        if (l.name == "StVenantKirchhoff" && form.find("Regularization") != std::string::npos) continue;  // has no J
        if (cubes && !form.empty() && form.find("projected") == std::string::npos) continue;  // not for hexahedra
        const auto sceneOf = [&](const std::string& a) { return cubes ? block(a) : lawScene(a); };
        FieldUnderTest t(sceneOf(l.attributes + prony + update("exponential") + form), typeOf(cubes));
        giveHistory(t);
        FieldUnderTest elastic(sceneOf(l.attributes + form), typeOf(cubes));
        copy(t.x, elastic.x);
        const Vector f = t.force();
        EXPECT_GT(relativeDifference(f, elastic.force()), 0.1) << "no viscosity was tested";
        expectConsistentDerivatives(t, f);
      }
}

TEST(ViscousLaw, EvaluationsChangeNoHistory) {
  FieldUnderTest t(lawScene(law + prony), tetrahedral);
  giveHistory(t);
  const History& history = dynamic_cast<History&>(t.field());
  const std::vector<double> before = history.history();
  const Vector f = t.force();
  for (unsigned seed = 20; seed < 25; ++seed) {
    t.field().setTime(0.07 + 0.01 * seed);
    t.deform(0.05, seed);
    t.force();
  }
  EXPECT_EQ(before, history.history());
  t.field().setTime(0.08);
  t.deform(0.02, 9);
  EXPECT_EQ(relativeDifference(f, t.force()), 0);
  FieldUnderTest elastic(lawScene(law), tetrahedral);
  EXPECT_TRUE(dynamic_cast<History&>(elastic.field()).history().empty());
  EXPECT_FALSE(elastic.field().traits().time_dependent);
}

std::string swinging(const std::string& word, const std::string& start = "0", const std::string& iterations = "8",
                     bool cubes = false) {
  const std::string body = cubes ? "<MechanicalObject position=\"@../grid.position\"/>"
                                 : "<TetrahedronSetTopologyContainer name=\"tets\"/><Hexa2TetraTopologicalMapping "
                                   "input=\"@../grid\" output=\"@tets\"/><MechanicalObject/>";
  return "<Node name=\"root\" dt=\"0.015625\" time=\"" + start +
         "\" gravity=\"0 0 -9.81\"><RegularGridTopology name=\"grid\" n=\"2 2 4\" min=\"0 0 0\" max=\"0.04 0.04 0.1\"/>"
         "<EulerImplicitSolver newtonIterations=\"" +
         iterations + "\"/><SparseLDLSolver/><Node name=\"b\">" + body + "<UniformMass totalMass=\"0.1\"/><" +
         typeOf(cubes) + " materialName=\"NeoHookean\" youngModulus=\"5000\" poissonRatio=\"0.4\"" + prony +
         update(word) +
         "/><BoxROI name=\"held\" box=\"-1 -1 -0.001 0.001 1 1\"/>"
         "<FixedProjectiveConstraint indices=\"@held.indices\"/></Node></Node>";
}
History& historyOf(Simulation& s) { return dynamic_cast<History&>(*s.systems()[0]->forceFields()[0]); }
void run(Simulation& s, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = s.step();
    ASSERT_FALSE(report.diverged) << report.reason;
  }
}

TEST(ViscousLaw, HistorySurvivesResetResumeAndDivergence) {
  for (const bool cubes : {false, true})
    for (const std::string& word : updates) {
      SCOPED_TRACE(word + (cubes ? " hexahedra" : ""));
      Simulation whole = simulationFromText(swinging(word, "0", "8", cubes));
      run(whole, 16);
      const std::uint64_t middle = whole.stateHash();
      System& from = *whole.systems()[0];
      Simulation resumed = simulationFromText(swinging(word, "0", "8", cubes));
      resumed.restore(whole.checkpoint());
      Simulation forgetful = simulationFromText(swinging(word, "0.25", "8", cubes));
      copy(from.x, forgetful.systems()[0]->x), copy(from.v, forgetful.systems()[0]->v);

      // a step that fails: an infinite energy on the way, and nothing of it remains
      Vector v(from.v.count());
      copy(from.v, v);
      from.v[from.v.count() - 1] = Vec3(0, 0, -1e200);
      const std::vector<double> kept = historyOf(whole).history();
      EXPECT_TRUE(whole.step().diverged);
      EXPECT_EQ(kept, historyOf(whole).history());
      copy(v, from.v);
      EXPECT_EQ(whole.stateHash(), middle);

      run(whole, 16), run(resumed, 16), run(forgetful, 16);
      EXPECT_EQ(whole.stateHash(), resumed.stateHash());
      EXPECT_NE(whole.stateHash(), forgetful.stateHash()) << "the history does not matter: nothing was tested";
      const std::uint64_t end = whole.stateHash();
      whole.reset();
      run(whole, 32);
      EXPECT_EQ(whole.stateHash(), end);
    }
}

/// The trapezoidal rule asks for forces at both ends of a step: a viscous body stays of second order.
TEST(ViscousLaw, OrderOfAMovingBody) {
  const auto shape = [](const std::string& solver, const std::string& word, int steps) {
    std::string text = swinging(word);
    const auto replace = [&](const std::string& from, const std::string& to) {
      text.replace(text.find(from), from.size(), to);
    };
    replace("<EulerImplicitSolver newtonIterations=\"8\"/>",
            "<EulerImplicitSolver newtonIterations=\"20\" newtonTolerance=\"1e-11\"" + solver + "/>");
    replace("dt=\"0.015625\"", "dt=\"" + std::to_string(0.125 / steps) + "\"");
    Simulation s = simulationFromText(text);
    run(s, steps);
    Vector x(s.systems()[0]->x.count());
    copy(s.systems()[0]->x, x);
    return x;
  };
  const auto order = [&](const std::string& solver, const std::string& word) {
    Vector a = shape(solver, word, 250), b = shape(solver, word, 500), c = shape(solver, word, 1000);
    axpy(-1, b, a), axpy(-1, c, b);
    const double coarse = std::sqrt(dot(a, a)), fine = std::sqrt(dot(b, b)), found = std::log2(coarse / fine);
    std::printf("%-30s %-12s order %.2f (differences %.2e %.2e m)\n", solver.c_str(), word.c_str(), found, coarse,
                fine);
    return found;
  };
  EXPECT_NEAR(order("", "backward"), 1, 0.1);
  EXPECT_NEAR(order("", "exponential"), 1, 0.1);
  EXPECT_LT(order(" trapezoidalScheme=\"true\"", "backward"), 1.7);
  EXPECT_NEAR(order(" trapezoidalScheme=\"true\"", "exponential"), 2, 0.1);
}

TEST(ViscousLaw, SeriesWithoutMeaningAreRefused) {
  const auto refused = [](const std::string& attributes, const std::string& words) {
    const std::string problems = problemsOf(oneCell(law + " " + attributes));
    EXPECT_NE(problems.find(words), std::string::npos) << attributes << ": " << problems;
  };
  refused("ParameterAlpha=\"0.2\" ParameterTau=\"1\"", "not whether it is used");
  refused("viscous=\"true\"", "ParameterAlpha has 0 values");
  refused("viscous=\"true\" ParameterAlpha=\"0.2 0.3\" ParameterTau=\"1\"", "ParameterAlpha has 2 values");
  refused("viscous=\"true\" ParameterAlpha=\"0.6 0.5\" ParameterTau=\"1 2\"", "sum to 1.1");
  refused("viscous=\"true\" ParameterAlpha=\"-0.1\" ParameterTau=\"1\"", "ParameterAlpha");
  refused("viscous=\"true\" ParameterAlpha=\"0.1\" ParameterTau=\"0\"", "ParameterTau");
  EXPECT_EQ(problemsOf(oneCell(law + " viscous=\"false\" ParameterAlpha=\"0.2\" ParameterTau=\"1\"")), "");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
