// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma sweep` as a user meets it: known orders, the goal, refusals.
#include "tests/sweep/sweep_fixture.h"

namespace stroma::test {
namespace {

// ---- orders ----

TEST_F(Sweep, ErrorOfABarFallsWithTheSquareOfTheMesh) {
  write("bar.xml", bar);
  const auto json = tableOf(std::string("bar.xml") + bar_meshes + bar_formula);
  ASSERT_EQ(json["series"].size(), 1u);
  EXPECT_NEAR(json["series"][0]["order"].get<double>(), 2, 1e-3);
  // nodes are exact; between them the parabola is missed by h^2 / 12 of its curvature at the two Gauss points
  const double h = 0.5, expected = h * h / 12 / std::sqrt(2.0 / 15);
  EXPECT_NEAR(json["configurations"][0]["error"].get<double>(), expected, 1e-3 * expected);
  for (const auto& row : json["configurations"]) EXPECT_EQ(row["outcome"], "done");
}

TEST_F(Sweep, EnergyOfABarHasTheOrderTwoOnceMore) {
  write("bar.xml", bar);
  const auto json = tableOf(std::string("bar.xml") + bar_meshes + "--error energy --reference '0.5*1e6*1e-4*1e-4/3'");
  EXPECT_NEAR(json["series"][0]["order"].get<double>(), 2, 0.01);
}

TEST_F(Sweep, ExtrapolationFindsTheExactSolution) {
  write("bar.xml", bar);
  const std::string line = std::string("bar.xml") + bar_meshes + "--error energy --reference ";
  const auto exact = tableOf(line + "'0.5*1e6*1e-4*1e-4/3'"), own = tableOf(line + "extrapolated");
  EXPECT_NEAR(own["estimates"][0]["order"].get<double>(), 2, 0.05);
  for (int i = 0; i < 4; ++i) {
    const double one = own["configurations"][i]["error"], other = exact["configurations"][i]["error"];
    EXPECT_NEAR(one, other, 0.02 * other + 1e-12) << i;
    EXPECT_LE(std::abs(one - other), own["error"]["uncertainty"].get<double>() + 1e-9) << i;
  }
  EXPECT_LT(own["error"]["uncertainty"].get<double>(), 0.3 * exact["configurations"][3]["error"].get<double>());
}

/// Between the nodes the error of a field oscillates, and no extrapolation removes it: the uncertainty has to say so.
TEST_F(Sweep, UncertaintyOfAnExtrapolatedFieldCoversItsError) {
  write("bar.xml", bar);
  const auto own = tableOf(std::string("bar.xml") + bar_meshes + "--reference extrapolated");
  const double told = own["error"]["uncertainty"];
  for (int i = 0; i < 3; ++i) {
    const double h = 0.5 / (1 << i), exact = h * h / std::sqrt(120.0) / std::sqrt(2.0 / 15);
    EXPECT_NEAR(own["configurations"][i]["error"].get<double>(), exact, told) << i;
  }
}

TEST_F(Sweep, UncertaintyOfTheFinestRunCoversItsError) {
  write("bar.xml", bar);
  const auto exact = tableOf(std::string("bar.xml") + bar_meshes + bar_formula);
  const auto own = tableOf(std::string("bar.xml") + bar_meshes + "--reference finest");
  const double error = exact["configurations"][3]["error"], told = own["error"]["uncertainty"];
  EXPECT_GT(told, error);
  EXPECT_LT(told, 2 * error);
  EXPECT_TRUE(own["configurations"][3]["is_reference"].get<bool>());
}

TEST_F(Sweep, EulersMethodHasTheOrderOneInTheTimeStep) {
  write("oscillator.xml", oscillator);
  const std::string steps = "oscillator.xml --vary dt=0.004,0.002,0.001,0.0005 --until 0.2 --repeat 1 -q ";
  const auto json = tableOf(steps + "--error /dofs.displacement --reference '0.1*sin(10*t); 0; 0'");
  EXPECT_NEAR(json["series"][0]["order"].get<double>(), 1, 0.05);
  const auto own = tableOf(steps + "--reference extrapolated");
  EXPECT_NEAR(own["estimates"][0]["order"].get<double>(), 1, 0.05);
  const double error = json["configurations"][0]["error"];
  EXPECT_NEAR(own["configurations"][0]["error"].get<double>(), error, 0.02 * error);
}

/// Components in the place of one another: backward Euler and two rules of order 2.
TEST_F(Sweep, IntegratorsAreComparedByTheirErrors) {
  write("oscillator.xml", oscillator);
  const auto json = tableOf("oscillator.xml --vary '/solver=EulerImplicitSolver rayleighMass=0,TrapezoidalRuleSolver,BDFOdeSolver order=2' "
                            "--vary dt=0.002,0.001 --until 0.2 --no-times -q --error /dofs.displacement --reference '0.1*sin(10*t); 0; 0'");
  ASSERT_EQ(json["configurations"].size(), 6u);
  const double orders[] = {1, 2, 2};
  for (int i = 0; i < 3; ++i) {
    const double coarse = json["configurations"][2 * i]["error"], fine = json["configurations"][2 * i + 1]["error"];
    EXPECT_NEAR(std::log2(coarse / fine), orders[i], 0.1) << i;
  }
}

/// 70, 110, 100 have differences that shrink like those of order 2, but they turn round.
TEST_F(Sweep, ValuesThatOscillateFollowNoOrder) {
  write("oscillator.xml", oscillator);
  const std::string line = "oscillator.xml --until 0.08 --repeat 1 -q --error /spring.stiffness --zip ";
  const auto turning = tableOf(line + "'dt=0.04,0.02,0.01; /spring.stiffness=70,110,100'");
  EXPECT_TRUE(turning["estimates"][0]["order"].is_null()) << turning["estimates"];
  EXPECT_NEAR(turning["error"]["uncertainty"].get<double>(), 3 * 0.4, 1e-9) << "three times the range";
  const auto steady = tableOf(line + "'dt=0.04,0.02,0.01; /spring.stiffness=50,90,100'");
  EXPECT_NEAR(steady["estimates"][0]["order"].get<double>(), 2, 1e-6);
  EXPECT_NEAR(steady["error"]["uncertainty"].get<double>(), 2.25 * 0.1 / 3, 1e-9);
  const auto steep = tableOf(line + "'dt=0.04,0.02,0.01; /spring.stiffness=19,99,100'");
  const double by_coarse = 0.8 / 3 / 4;
  EXPECT_NEAR(steep["error"]["uncertainty"].get<double>(), 0.01 / 3 + 5 * by_coarse, 1e-9)
      << "faster than an order of 2";
}

TEST_F(Sweep, ANumberThatOrdersNothingIsTold) {
  write("oscillator.xml", oscillator);
  const std::string line = "oscillator.xml --until 0.08 --repeat 1 -q --error /dofs.displacement --vary ";
  const auto notes = [&](const std::string& vary) { return tableOf(line + vary)["notes"].dump(); };
  EXPECT_NE(notes("/spring.stiffness=50,100").find("spring.stiffness orders nothing: what is called error is the "
                                                   "difference to its last value, 100"),
            std::string::npos);
  EXPECT_NE(notes("'/spring.stiffness=50 N/m,100N/m'").find("spring.stiffness orders nothing"), std::string::npos);
  for (const char* vary : {"dt=0.04,0.02", "threads=2,4", "/linear.iterations=10,20"})
    EXPECT_EQ(notes(vary).find("orders nothing"), std::string::npos) << vary;
}

/// Backward Euler from v = 1 under -k x: two steps of h have v1 = 1 / (1 + k h^2), x1 = h v1 and so on.
TEST_F(Sweep, AStudyOfAStiffnessHasItsValues) {
  write("oscillator.xml", oscillator);
  const auto json = tableOf("oscillator.xml -n 2 --repeat 1 -q --error /dofs.displacement --vary /spring.stiffness=50,100");
  for (const auto& row : json["configurations"]) {
    const double k = std::stod(row["settings"]["/spring.stiffness"].get<std::string>()), h = 0.01;
    double x = 0, v = 1;
    for (int step = 0; step < 2; ++step) v = (v - h * k * x) / (1 + k * h * h), x += h * v;
    EXPECT_NEAR(row["value"][0].get<double>(), x, 1e-9 * x);
    EXPECT_EQ(row["value"].size(), 3u);
  }
  EXPECT_EQ(stroma("sweep oscillator.xml -n 1 --repeat 1 -q --error energy --vary /spring.stiffness=50,100 -o kept").code, 0);
  EXPECT_NE(readText(folder_ / "kept" / "table.csv").find(",value,"), std::string::npos);
  EXPECT_TRUE(table("kept")["configurations"][0]["value"].is_number());
}

/// A held cell under simple shear g: of its strain xy = g / 2 alone is not zero, and the error is that of all entries.
TEST_F(Sweep, ATensorHasAllItsNumbers) {
  const auto sheared = [](const std::string& g) {
    return "0 0 0 1 0 0 " + g + " 1 0 1." + g.substr(2) + " 1 0 0 0 1 1 0 1 " + g + " 1 1 1." + g.substr(2) + " 1 1";
  };
  write("cell.xml", R"(<Node name="root" gravity="0 0 0" dt="0.01"><EulerImplicitSolver/><CGLinearSolver iterations="50" tolerance="1e-12"/>
    <RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs" rest_position=")" +
                        sheared("0.0") + "\"/><UniformMass totalMass=\"1\"/>" +
                        R"(<HexahedronFEMForceField name="fem" method="small"/><FixedProjectiveConstraint fixAll="true"/></Node>)");
  const auto json = tableOf("cell.xml -n 1 --repeat 1 -q --error /fem.strain --vary '/dofs.position=" + sheared("0.1") + "," +
                            sheared("0.2") + "'");
  for (int row = 0; row < 2; ++row) {
    const std::vector<double> value = json["configurations"][row]["value"];
    ASSERT_EQ(value.size(), 6u);
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(value[k], k == 3 ? 0.05 * (row + 1) : 0, 1e-12) << k;
  }
  EXPECT_NEAR(json["configurations"][0]["error"].get<double>(), 0.5, 1e-12);
}

/// Each configuration is a line at the end, with its values, what is compared, the error, or what became of it.
TEST_F(Sweep, TheTableIsForPeopleToo) {
  write("oscillator.xml", oscillator);
  const std::string line = "sweep oscillator.xml -n 2 --no-times -q --error /dofs.displacement --vary /spring.stiffness=50,100 -o out";
  const Finished done = stroma(line + " --vary /solver.rayleighMass=0,1");
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_TRUE(has(done.out, "spring.stiffness  solver.rayleighMass")) << done.out;
  EXPECT_TRUE(has(done.out, "dofs.displacement")) << done.out;
  for (const auto& row : table("out")["configurations"]) {
    char value[64];
    std::snprintf(value, sizeof value, "%.4g 0 0", row["value"][0].get<double>());
    EXPECT_TRUE(has(done.out, value)) << value << done.out;
  }
}

TEST_F(Sweep, TwoValuesAreUncertainByTheirRatio) {
  write("oscillator.xml", oscillator);
  const auto json = tableOf(
      "oscillator.xml --until 0.12 --repeat 1 -q --error /spring.stiffness --zip "
      "'dt=0.012,0.01; /spring.stiffness=99,100'");
  EXPECT_NEAR(json["error"]["uncertainty"].get<double>(), 3 * 0.01 / 0.2, 1e-9);
}

/// A cantilever of hexahedra without lateral contraction under an end load. Timoshenko's beam is exact to 1e-4:
/// w = F L^3 / (3 E I) + F L / (5/6 G A), with F = 1e-3, E = 1e6, I = h^4 / 12, G = E / 2.
constexpr const char* cantilever = R"(<Node name="root" gravity="0 0 0" dt="1">
  <Node name="beam">
    <StaticSolver/><SparseLDLSolver/>
    <RegularGridTopology name="grid" n="21 2 2" min="0 0 0" max="0.2 0.01 0.01"/>
    <MechanicalObject name="dofs"/>
    <HexahedronFEMForceField name="fem" method="small" youngModulus="1e6" poissonRatio="0"/>
    <BoxROI name="held" box="-1 -1 -1  1e-6 1 1"/>
    <BoxROI name="end" box="0.1999 -1 -1  1 1 1"/>
    <FixedProjectiveConstraint indices="@held.indices"/>
    <ConstantForceField indices="@end.indices" totalForce="0 -1e-3 0"/>
  </Node>
</Node>)";
constexpr double deflection = 1e-3 * 0.008 / (3 * 1e6 * 1e-8 / 12) + 1e-3 * 0.2 / (5. / 6 * 5e5 * 1e-4);
constexpr const char* at_the_end = " -n 1 --no-times -q --error '/beam/dofs.displacement:(0.2 0.005 0.005)' ";

/// Full integration locks in shear: one, two and four cells over the height are far from their order of 2.
TEST_F(Sweep, AnExtrapolatedCantileverIsNoBetterKnownThanItIs) {
  write("beam.xml", cantilever);
  for (const char* meshes : {"21 2 2,41 3 3,81 5 5", "21 3 3,41 3 3,81 5 5", "11 2 2,21 2 2,41 3 3"}) {
    const auto own =
        tableOf(std::string("beam.xml --reference extrapolated --vary '/beam/grid.n=") + meshes + "'" + at_the_end);
    const auto exact = tableOf("beam.xml --reference '0;" + std::to_string(-deflection) +
                               ";0' --vary '/beam/grid.n=" + meshes + "'" + at_the_end);
    for (int i = 0; i < 3; ++i)
      EXPECT_LE(
          std::abs(own["configurations"][i]["error"].get<double>() - exact["configurations"][i]["error"].get<double>()),
          own["error"]["uncertainty"].get<double>())
          << meshes;
  }
}

TEST_F(Sweep, UnevenRefinementIsFoundAndSaid) {
  write("beam.xml", cantilever);
  const auto notesOf = [&](const std::string& meshes) {
    const auto json = tableOf("beam.xml --vary '/beam/grid.n=" + meshes + "'" + at_the_end);
    return std::pair(json["notes"].dump(), json["error"]["uncertainty_is_whole"].get<bool>());
  };
  EXPECT_EQ(notesOf("21 2 2,41 3 3,81 5 5"), std::pair(std::string("[]"), true));
  const auto [uneven, uneven_is_whole] = notesOf("21 3 3,41 3 3,81 5 5");
  EXPECT_TRUE(has(uneven, "from 21 3 3 to 41 3 3 the spacing falls by 2 along x and by 1 along")) << uneven;
  EXPECT_TRUE(uneven_is_whole);
  const auto [fixed, fixed_is_whole] = notesOf("21 2 2,41 2 2,81 2 2");
  EXPECT_TRUE(has(fixed, "not refined along")) << fixed;
  EXPECT_FALSE(fixed_is_whole) << "the height keeps one cell: nothing tells what that costs";
}

/// Of three meshes the third is refused: two are left, and they tell an uncertainty as two do.
TEST_F(Sweep, AMeshThatIsRefusedLeavesTheOthersTheirUncertainty) {
  write("beam.xml", cantilever);
  const auto two = tableOf(std::string("beam.xml --vary '/beam/grid.n=21 2 2,41 3 3'") + at_the_end);
  for (const char* meshes : {"21 2 2,41 3 3,81 1 1", "81 1 1,21 2 2,41 3 3", "21 2 2,81 1 1,41 3 3"}) {
    const auto three = tableOf(std::string("beam.xml --vary '/beam/grid.n=") + meshes + "'" + at_the_end);
    ASSERT_TRUE(three["error"]["uncertainty"].is_number()) << meshes << three["notes"];
    EXPECT_DOUBLE_EQ(three["error"]["uncertainty"].get<double>(), two["error"]["uncertainty"].get<double>()) << meshes;
    EXPECT_GT(two["error"]["uncertainty"].get<double>(), 0.1);
  }
  const auto one = tableOf(std::string("beam.xml --vary '/beam/grid.n=21 2 2,81 1 1'") + at_the_end);
  EXPECT_TRUE(one["error"]["uncertainty"].is_null()) << "nothing tells it";
  EXPECT_TRUE(has(one["notes"].dump(), "unknown")) << one["notes"];
}

// ---- failures, zip, goal ----

TEST_F(Sweep, FailuresAreRowsAndNeverOnTheFront) {
  write("bar.xml", bar);
  const auto json = tableOf(
      "bar.xml --vary /bar/fem.youngModulus=1e6,1e-6 --vary '/bar/grid.n=2 3 2,2 5 2' -n 1 --repeat 1 -q "
      "--set /bar/fem.method=large");
  int failed = 0;
  for (const auto& row : json["configurations"])
    if (row["settings"]["/bar/fem.youngModulus"] == "1e-6") {
      ++failed;
      EXPECT_NE(row["outcome"], "done");
      EXPECT_NE(row.value("sentence", ""), "");
      EXPECT_FALSE(row["on_front"].get<bool>());
      EXPECT_TRUE(row["error"].is_null());
    }
  EXPECT_EQ(failed, 2);
}

TEST_F(Sweep, ZipVariesAttributesTogether) {
  write("bar.xml", bar);
  const auto json =
      tableOf("bar.xml --zip '/bar/grid.n=2 3 2,2 5 2; /bar/fem.youngModulus=1e6,1e6' -n 1 --repeat 1 -q");
  ASSERT_EQ(json["configurations"].size(), 2u);
  EXPECT_EQ(json["configurations"][1]["settings"]["/bar/grid.n"], "2 5 2");
  EXPECT_EQ(json["series"][0]["axis"], "grid.n, fem.youngModulus");
}

/// The one with the longest step that is exact enough takes the fewest of them. The search looks at the middle one first,
/// which is not: what is coarser is spoken for, and of the finer ones the first will do, whatever the times are. How times
/// are weighed: test_goal.cpp.
TEST_F(Sweep, TheGoalIsTheCheapestOfTheWholeGrid) {
  write("oscillator.xml", oscillator);
  const std::string grid =
      "sweep oscillator.xml --vary dt=1e-3,5e-4,1e-4,2e-5,4e-6 --until 0.2 --repeat 1 -q --error /dofs.displacement "
      "--reference '0.1*sin(10*t); 0; 0' -o ";
  ASSERT_EQ(stroma(grid + "whole").code, 0);
  std::string wanted;
  double longest_step = 0;
  const auto whole = table("whole");
  for (const auto& row : whole["configurations"]) {
    const double dt = std::stod(row["settings"]["dt"].get<std::string>());
    EXPECT_GT(row["seconds"].get<double>(), 0);
    if (row["error"].get<double>() < 5e-4 && dt > longest_step) wanted = row["command"], longest_step = dt;
  }
  EXPECT_EQ(longest_step, 2e-5) << "the fourth of five";
  const Finished search = stroma(grid + "goal --goal 'error<0.05%'");
  ASSERT_EQ(search.code, 0) << search.err;
  EXPECT_TRUE(has(search.out, "  " + wanted + "\n")) << search.out << wanted;
  EXPECT_EQ(table("goal")["configurations"].size(), 2u);
  EXPECT_EQ(table("goal")["not_run"].get<int>(), 3);
  EXPECT_EQ(stroma(grid + "goal --goal 'error<0.00001%'").code, 1);
}

// ---- refusals ----

/// Errors are measured in tetrahedra and hexahedra: what has other cells is refused before its first step.
TEST_F(Sweep, PrismsAreRefusedBeforeARun) {
  write("prism.xml", R"(<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/><CGLinearSolver/>
    <MeshTopology position="0 0 0 1 0 0 0 1 0 0 0 1 1 0 1 0 1 1" prisms="0 1 2 3 4 5"/><MechanicalObject name="dofs"/>
    <UniformMass totalMass="500"/><CorotationalFEMForceField name="fem" youngModulus="1e5" poissonRatio="0.3"/>
    <FixedProjectiveConstraint indices="0 1 2"/></Node>)");
  const std::string sentence = "errors are measured in tetrahedra and hexahedra";
  const Finished run = stroma("run prism.xml -n 3 --measure end.values --record made");
  EXPECT_EQ(run.code, 2) << run.err;
  EXPECT_TRUE(has(run.err, sentence)) << run.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "made")) << "no step was made";
  const Finished sweep = stroma("sweep prism.xml --vary /fem.youngModulus=1e5,2e5 -n 3 -o out -q");
  EXPECT_EQ(sweep.code, 2) << sweep.err;
  EXPECT_TRUE(has(sweep.err, sentence) && has(sweep.err, "nothing was run")) << sweep.err;
}

TEST_F(Sweep, BadInputIsRefusedBeforeAnythingIsRun) {
  write("bar.xml", bar);
  const std::pair<const char*, const char*> cases[] = {
      {"--vary /bar/fem.yuongModulus=1,2 -n 1", "did you mean 'youngModulus'"},
      {"--vary /bar/femm.youngModulus=1,2 -n 1", "did you mean '/bar/fem'"},
      {"--vary /bar/fem.method=small,lrage -n 1", "large"},
      {"--vary dt=1,2 -n 1", "give --until"},
      {"-n 1", "nothing varies"},
      {"--vary /bar/fem.method=small --error L3 -n 1", "expected l2, max, energy"},
      {"--vary /bar/fem.method=small --error /bar/dofs.displacment -n 1", "did you mean 'displacement'"},
      {"--vary /bar/fem.method=small --reference fines -n 1", "neither finest nor extrapolated"},
      {"--vary /bar/fem.method=small --reference extrapolated -n 1", "needs three values"},
      {"--vary /bar/fem.method=small --goal 1% -n 1", "error<1%"},
      {"--vary /bar/fem.method=small --reference-set /bar/grid.m=3 -n 1", "m"},
      {"--vary /bar/fem.method=small --reepat 2", "did you mean --repeat"},
      {"--vary threads=1,x -n 1", "whole numbers"},
      {"--vary threads=1,01 -n 1", "are the same run"},
      {"--zip '/bar/fem.youngModulus=1,2,1; /bar/fem.poissonRatio=0,0.1,0' -n 1", "is there twice"},
      {"--vary dt=0.04,0.03 --until 0.12 --error '/bar/dof.position:(0 0.5 0)'", "there is no state /bar/dof"},
      {"--vary dt=0.04,0.03 --until 0.05", "expected a whole number"},
  };
  for (const auto& [arguments, expected] : cases) {
    const Finished run = stroma(std::string("sweep bar.xml ") + arguments + " -o out");
    EXPECT_EQ(run.code, 2) << arguments << "\n" << run.err;
    EXPECT_TRUE(has(run.err, expected)) << arguments << "\n" << run.err;
    EXPECT_FALSE(exists("out")) << arguments;
  }
  EXPECT_EQ(stroma("sweep bar.xml --vary /bar/fem.method=small -n 1").code, 2) << "no -o";
  EXPECT_EQ(stroma("sweep none.xml --vary /bar/fem.method=small -n 1 -o out").code, 2);
}

// ---- the report ----

TEST_F(Sweep, TheReportIsOneFileAndTheTablesAgree) {
  write("bar.xml", bar);
  ASSERT_EQ(stroma(std::string("sweep bar.xml") + bar_meshes + "--vary /bar/fem.method=small,large -o out").code, 0);
  const std::string page = readText(folder_ / "out/report.html"), csv = readText(folder_ / "out/table.csv");
  for (const char* elsewhere : {"src=", "href=", "http://", "https://", "@import", "url("}) {
    std::string text = page;
    for (std::size_t at; (at = text.find("http://www.w3.org/2000/svg")) != std::string::npos;) text.erase(at, 26);
    EXPECT_FALSE(has(text, elsewhere)) << elsewhere;
  }
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 8);
  EXPECT_TRUE(has(page, "order 2.0"));
  for (const char* file : {"out/work_precision.svg", "out/error_1.svg", "out/table.json"})
    EXPECT_TRUE(exists(file)) << file;
  const auto json = table("out");
  EXPECT_EQ(json["configurations"].size(), 8u);
  for (const char* key : {"seed", "build", "machine", "scene_digest"}) EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_TRUE(json["configurations"][0]["measured"][0].contains("load_at_start"));
}

}  // namespace
}  // namespace stroma::test
