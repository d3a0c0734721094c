// SPDX-License-Identifier: LGPL-2.1-or-later
// What the exporter writes, read back by VTK: positions and fields of each time, the list of files, options and errors.
#include <tinyxml2.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "tests/support/quadratic_block.h"
#include "tests/vtk_io/vtk_fixture.h"
#include "tools/session/checkpoint.h"

namespace stroma::test {
namespace {

/// A hanging beam of tetrahedra with an exporter.
std::string beam(const std::string& exporter) {
  return R"(<Node name="root" dt="0.02"><Node name="body">
    <EulerImplicitSolver/><CGLinearSolver iterations="50" tolerance="1e-9" threshold="1e-30"/>
    <RegularGridTopology name="grid" n="4 2 2" min="0 0 0" max="3 1 1"/>
    <MechanicalObject name="state"/><UniformMass totalMass="3"/>
    <BoxROI name="clamp" box="-0.1 -1 -1 0.1 2 2"/><FixedProjectiveConstraint indices="@clamp.indices"/>
    <Node name="tets">
      <TetrahedronSetTopologyContainer name="mesh"/><Hexa2TetraTopologicalMapping input="@../grid" output="@mesh"/>
      <TetrahedronFEMForceField name="fem" mstate="@../state" youngModulus="2000" poissonRatio="0.3" method="polar"/>
      )" +
         exporter + "</Node></Node></Node>";
}

vtkSmartPointer<vtkUnstructuredGrid> read(const std::filesystem::path& path) {
  const auto reader = vtkSmartPointer<vtkXMLUnstructuredGridReader>::New();
  reader->SetFileName(path.c_str());
  reader->Update();
  return reader->GetOutput();
}

/// (time, file) of each entry of a .pvd file.
std::vector<std::pair<double, std::string>> entries(const std::filesystem::path& path) {
  tinyxml2::XMLDocument document;
  std::vector<std::pair<double, std::string>> out;
  if (document.LoadFile(path.c_str()) != tinyxml2::XML_SUCCESS) return out;
  const auto* set = document.RootElement()->FirstChildElement("Collection")->FirstChildElement("DataSet");
  for (; set; set = set->NextSiblingElement("DataSet"))
    out.emplace_back(set->DoubleAttribute("timestep"), set->Attribute("file"));
  return out;
}

class Exporter : public VtkTest {
 protected:
  std::string exporter(const std::string& attributes) const {
    return "<VTKExporter name=\"out\" filename=\"" + (folder_ / "new" / "beam").string() + "\" " + attributes + "/>";
  }
  std::filesystem::path at(const std::string& name) const { return folder_ / "new" / name; }
};

TEST_F(Exporter, WritesEveryStepByDefaultAndTheListIsAlwaysValid) {
  Simulation simulation = simulationFromText(beam(exporter("")));
  for (int step = 1; step <= 3; ++step) {
    simulation.step();
    const auto list = entries(at("beam.pvd"));
    ASSERT_EQ(list.size(), std::size_t(step));
    EXPECT_NEAR(list.back().first, 0.02 * step, 1e-12);
    EXPECT_TRUE(std::filesystem::exists(at(list.back().second)));
  }
  EXPECT_EQ(entries(at("beam.pvd"))[0].second, "beam00000.vtu");
  long files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_ / "new")) ++files;
  EXPECT_EQ(files, 4);  // no temporary file is left
}

TEST_F(Exporter, ValuesComeBackToTheLastBit) {
  Simulation simulation =
      simulationFromText(beam(exporter(R"(pointsDataFields="velocity u=displacement force rest=state.rest_position"
                       cellsDataFields="stress=fem.vonMises cauchy=fem.stress fem.principalStress" mstate="@../state")")));
  simulation.step();
  simulation.step();
  const auto grid = read(at("beam00001.vtu"));
  const State& state = *simulation.states().front();
  ASSERT_EQ(grid->GetNumberOfPoints(), state.size());
  ASSERT_EQ(grid->GetNumberOfCells(), 18);
  EXPECT_EQ(grid->GetFieldData()->GetArray("TimeValue")->GetTuple1(0), simulation.time());
  double moved = 0;
  for (Index n = 0; n < state.size(); ++n) {
    double value[3];
    const auto expect = [&](const char* name, const Vec3& expected) {
      if (!name)
        grid->GetPoint(n, value);
      else
        grid->GetPointData()->GetArray(name)->GetTuple(n, value);
      EXPECT_EQ(Vec3(value[0], value[1], value[2]), expected) << (name ? name : "position") << " of node " << n;
    };
    expect(nullptr, state.x()[n]);
    expect("velocity", state.v()[n]);
    expect("force", state.f()[n]);
    expect("u", state.x()[n] - state.rest_position[n]);
    expect("rest", state.rest_position[n]);
    moved = std::max(moved, (Vec3(state.x()[n]) - state.rest_position[n]).norm());
  }
  EXPECT_GT(moved, 1e-4);
  const auto* fem = dynamic_cast<ForceField*>(findComponent(simulation.root(), "/body/tets/fem"));
  std::vector<double> stress;
  fem->cellField("vonMises", simulation.systems().front()->x, stress);
  double largest = 0;
  for (vtkIdType c = 0; c < 18; ++c) {
    EXPECT_EQ(grid->GetCellData()->GetArray("stress")->GetTuple1(c), stress[c]);
    largest = std::max(largest, stress[c]);
  }
  EXPECT_GT(largest, 0);
  for (const auto& [label, field, width] : {std::tuple("cauchy", "stress", 6), std::tuple("principalStress", "principalStress", 3)}) {
    auto* array = grid->GetCellData()->GetArray(label);
    ASSERT_TRUE(array) << label;
    ASSERT_EQ(array->GetNumberOfComponents(), width) << "ParaView takes six for a symmetric tensor";
    fem->cellField(field, simulation.systems().front()->x, stress);
    for (vtkIdType c = 0; c < 18; ++c)
      for (int k = 0; k < width; ++k) EXPECT_EQ(array->GetComponent(c, k), stress[std::size_t(width * c + k)]);
  }
}

TEST_F(Exporter, ARestartedRunGoesOnWithItsFiles) {
  const std::string scene = beam(exporter("exportEveryNumberOfSteps=\"2\" exportAtBegin=\"true\""));
  std::string stored;
  {
    Simulation simulation = simulationFromText(scene);
    for (int step = 1; step <= 5; ++step) simulation.step();
    stored = Checkpoint{"beam.xml", buildIdentity(), simulation.checkpoint()}.bytes();
  }
  const std::string first = bytesOf(at("beam00000.vtu")), third = bytesOf(at("beam00002.vtu"));
  Simulation restarted = simulationFromText(scene);
  restarted.restore(Checkpoint::fromBytes(stored, "memory").values);
  for (int step = 6; step <= 8; ++step) restarted.step();
  const auto list = entries(at("beam.pvd"));
  ASSERT_EQ(list.size(), 5u) << "the start and steps 2, 4, 6 and 8";
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_NEAR(list[i].first, 0.04 * double(i), 1e-12);
    EXPECT_EQ(list[i].second, "beam0000" + std::to_string(i) + ".vtu");
  }
  EXPECT_EQ(bytesOf(at("beam00000.vtu")), first);
  EXPECT_EQ(bytesOf(at("beam00002.vtu")), third);
  EXPECT_NE(bytesOf(at("beam00004.vtu")), third);
}

/// Readers colour by the ranges in the head of a file.
TEST_F(Exporter, RangesInAFileAreThoseOfItsValues) {
  Simulation simulation =
      simulationFromText(beam(exporter("pointsDataFields=\"displacement\" exportAtBegin=\"true\"")));
  simulation.step();
  std::ifstream stream(at("beam00001.vtu"), std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const auto largest = [&text](const std::string& name) {
    const std::size_t array = text.find("Name=\"" + name + "\"");
    return std::stod(text.substr(text.find("RangeMax=\"", array) + 10));
  };
  EXPECT_NEAR(largest("TimeValue"), 0.02, 1e-12);
  EXPECT_GT(largest("displacement"), 0);
}

TEST_F(Exporter, RoundTripThroughTheLoader) {
  for (const bool xml : {true, false}) {
    Simulation simulation = simulationFromText(beam(exporter(xml ? "" : "XMLformat=\"false\"")));
    simulation.step();
    const Mesh mesh = load("MeshVTKLoader", at(xml ? "beam00000.vtu" : "beam00000.vtk"));
    const State& state = *simulation.states().front();
    ASSERT_EQ(mesh.nodes(), state.size());
    for (Index n = 0; n < mesh.nodes(); ++n) EXPECT_EQ(mesh.position[n], Vec3(state.x()[n]));
    const auto& original = dynamic_cast<Topology&>(*findComponent(simulation.root(), "/body/tets/mesh")).mesh();
    EXPECT_EQ(mesh.tetrahedra, original.tetrahedra);
  }
}

TEST_F(Exporter, QuadraticTetrahedraComeBack) {
  for (const bool xml : {true, false}) {
    Simulation simulation = simulationFromText(quadraticScene(
        "", "QuadraticTetrahedronFEMForceField name=\"fem\" youngModulus=\"3000\" poissonRatio=\"0.4\"",
        "<SparseLDLSolver/>", {2, 1, 1}, exporter(xml ? "cellsDataFields=\"vonMises\"" : "XMLformat=\"false\"")));
    simulation.step();
    const Mesh mesh = load("MeshVTKLoader", at(xml ? "beam00000.vtu" : "beam00000.vtk"));
    const State& state = *simulation.states().front();
    ASSERT_EQ(mesh.nodes(), state.size());
    for (Index n = 0; n < mesh.nodes(); ++n) EXPECT_EQ(mesh.position[n], Vec3(state.x()[n]));
    const auto& original = dynamic_cast<Topology&>(*findComponent(simulation.root(), "/body/mesh")).mesh();
    EXPECT_EQ(original.quadratic_tetrahedra.size(), 12u);
    EXPECT_EQ(mesh.quadratic_tetrahedra, original.quadratic_tetrahedra);
  }
}

TEST_F(Exporter, PrismsAndPyramidsComeBack) {
  for (const bool xml : {true, false}) {
    Simulation simulation = simulationFromText(
        R"(<Node name="root" gravity="0 0 0" dt="1"><StaticSolver/><SparseLDLSolver/>
        <MeshTopology name="mesh" position="0 0 0  1 0 0  0 1 0  0 0 1  1 0 1  0 1 1  2 2 0.5" prisms="0 1 2 3 4 5" pyramids="1 2 5 4 6"/>
        <MechanicalObject name="state"/><FixedProjectiveConstraint indices="0 1 2"/>
        <CorotationalFEMForceField name="fem" template="Vec3,Prism" youngModulus="1000" poissonRatio="0"/>
        <CorotationalFEMForceField name="top" template="Vec3,Pyramid" youngModulus="1000" poissonRatio="0"/>)" +
        exporter(xml ? "cellsDataFields=\"fem.vonMises\"" : "XMLformat=\"false\"") + "</Node>");
    simulation.step();
    const Mesh mesh = load("MeshVTKLoader", at(xml ? "beam00000.vtu" : "beam00000.vtk"));
    EXPECT_EQ(mesh.prisms, (std::vector<Prism>{{0, 1, 2, 3, 4, 5}}));
    EXPECT_EQ(mesh.pyramids, (std::vector<Pyramid>{{1, 2, 5, 4, 6}}));
  }
}

/// A hexahedron is pulled to a stress of 100 Pa and a strain of 0.1; the stiff tetrahedron on it goes along unstrained.
TEST_F(Exporter, FieldsAreOnTheCellsOfTheirForceFieldWhereThereAreAsManyOfAnotherKind) {
  Simulation simulation = simulationFromText(
      R"(<Node name="root" gravity="0 0 0" dt="1"><StaticSolver/><SparseLDLSolver/>
      <MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1  0.5 0.5 2"
                    hexahedra="0 1 2 3 4 5 6 7" tetrahedra="4 5 6 8"/><MechanicalObject/>
      <HexahedronFEMForceField name="hexa" method="small" youngModulus="1000" poissonRatio="0"/>
      <TetrahedronFEMForceField name="tetra" method="small" youngModulus="1e6" poissonRatio="0"/>
      <FixedProjectiveConstraint indices="0 1 2 3"/><ConstantForceField indices="4 5 6 7" totalForce="0 0 100"/>)" +
      exporter(R"(cellsDataFields="hexa=hexa.vonMises tetra=tetra.vonMises strain=hexa.strain")") + "</Node>");
  simulation.step();
  const auto grid = read(at("beam00000.vtu"));
  ASSERT_EQ(grid->GetNumberOfCells(), 2);
  ASSERT_EQ(grid->GetCellType(0), VTK_TETRA);
  vtkCellData& data = *grid->GetCellData();
  EXPECT_TRUE(std::isnan(data.GetArray("hexa")->GetTuple1(0)));
  EXPECT_NEAR(data.GetArray("hexa")->GetTuple1(1), 100, 1e-9);
  EXPECT_NEAR(data.GetArray("tetra")->GetTuple1(0), 0, 1e-6);
  EXPECT_TRUE(std::isnan(data.GetArray("tetra")->GetTuple1(1)));
  ASSERT_EQ(data.GetArray("strain")->GetNumberOfComponents(), 6);
  for (int k = 0; k < 6; ++k) {
    EXPECT_TRUE(std::isnan(data.GetArray("strain")->GetComponent(0, k)));
    EXPECT_NEAR(data.GetArray("strain")->GetComponent(1, k), k == 2 ? 0.1 : 0, 1e-12);
  }
}

TEST_F(Exporter, WhenAndHowOften) {
  const auto times = [this](const std::string& attributes, int steps) {
    std::filesystem::remove_all(folder_ / "new");
    Simulation simulation = simulationFromText(beam(exporter(attributes)));
    simulation.begin();
    for (int i = 0; i < steps; ++i) simulation.step();
    simulation.end();
    std::vector<long> out;
    for (const auto& [time, file] : entries(at("beam.pvd"))) out.push_back(std::lround(time / 0.02));
    return out;
  };
  using Times = std::vector<long>;
  EXPECT_EQ(times("exportEveryNumberOfSteps=\"2\"", 5), (Times{2, 4}));
  EXPECT_EQ(times("exportEveryNumberOfSteps=\"2\" exportAtBegin=\"1\" exportAtEnd=\"1\"", 5), (Times{0, 2, 4, 5}));
  EXPECT_EQ(times("exportEveryNumberOfSteps=\"2\" exportAtEnd=\"1\"", 4), (Times{2, 4}));
  EXPECT_EQ(times("exportEveryNumberOfSteps=\"0\" exportAtEnd=\"1\"", 3), (Times{3}));
  EXPECT_EQ(times("enable=\"0\"", 3), Times{});
  EXPECT_EQ(times("overwrite=\"1\"", 3), (Times{3}));
  EXPECT_TRUE(std::filesystem::exists(at("beam.vtu")));
  EXPECT_FALSE(std::filesystem::exists(at("beam00000.vtu")));
}

TEST_F(Exporter, CellsThatAreAskedFor) {
  const std::string start = R"(<Node name="root"><MeshTopology name="m" position="0 0 0 1 0 0 0 1 0 0 0 1" edges="0 1"
    triangles="0 1 2 0 2 3" )";
  const auto cells = [&](const std::string& tetrahedra, const std::string& attributes) {
    Simulation simulation = simulationFromText(
        start + tetrahedra + "/><EulerExplicitSolver/><MechanicalObject/><UniformMass totalMass=\"1\"/>" +
        exporter(attributes) + "</Node>");
    simulation.step();
    return read(at("beam00000.vtu"))->GetNumberOfCells();
  };
  EXPECT_EQ(cells("tetrahedra=\"0 1 2 3\"", ""), 1);
  EXPECT_EQ(cells("tetrahedra=\"0 1 2 3\"", "triangles=\"1\""), 3);
  EXPECT_EQ(cells("tetrahedra=\"0 1 2 3\"", "tetras=\"0\" edges=\"1\""), 1);
  EXPECT_EQ(cells("", ""), 2);
}

TEST_F(Exporter, SaysWhatIsWrong) {
  const auto with = [this](const std::string& attributes) { return problemsOf(beam(exporter(attributes))); };
  EXPECT_EQ(with(""), "");
  expectContains(with("pointsDataFields=\"velocitty\""), "did you mean 'velocity'");
  expectContains(with("cellsDataFields=\"fem.vonMisses\""), "vonMises");
  expectContains(with("cellsDataFields=\"nobody.vonMises\""), "no component 'nobody'");
  expectContains(with("cellsDataFields=\"mesh.vonMises\""), "is not a force field");
  expectContains(with("cellsDataFields=\"nothing\""), "0 force fields of the node have 'nothing'");
  expectContains(with("topology=\"@../state\""), "topology");
  expectContains(problemsOf("<Node name=\"root\">" + exporter("") + "</Node>"), "there is no state to export");
}

TEST_F(Exporter, AFolderThatCannotBeMadeIsASentence) {
  write("new", "a file where the folder should be");
  Simulation simulation = simulationFromText(beam(exporter("")));
  EXPECT_THROW(simulation.step(), std::exception);
}

/// Frames without a mesh are vertices that turn.
TEST_F(Exporter, WritesFramesWithTheirOrientations) {
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerExplicitSolver/><MechanicalObject name=\"state\" "
      "template=\"Rigid3\" position=\"1 2 3  0 0 0 1   4 5 6  0.6 0 0 0.8\" velocity=\"0 0 0 0 0 3  1 0 0 0 2 0\"/>"
      "<UniformMass totalMass=\"2\" inertia=\"1 1 1\"/><ConstantForceField indices=\"0\" forces=\"0 1 0  0 0 5\"/>" +
      exporter("pointsDataFields=\"velocity w=angularVelocity torque\"") + "</Node>");
  for (int i = 0; i < 2; ++i) simulation.step();
  const System& system = *simulation.systems()[0];
  const auto grid = read(at("beam00001.vtu"));
  ASSERT_EQ(grid->GetNumberOfPoints(), 2);
  ASSERT_EQ(grid->GetNumberOfCells(), 2);
  vtkDataArray* turns = grid->GetPointData()->GetArray("orientation");
  ASSERT_TRUE(turns);
  ASSERT_EQ(turns->GetNumberOfComponents(), 4);
  for (vtkIdType node = 0; node < 2; ++node) {
    EXPECT_EQ(grid->GetCellType(node), VTK_VERTEX);
    for (int c = 0; c < 4; ++c)
      EXPECT_EQ(turns->GetComponent(node, c), system.x.rows().data[std::size_t(8 * node + 4 + c)]) << node << c;
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(grid->GetPoint(node)[c], system.x[Index(2 * node)][c]);
      EXPECT_EQ(grid->GetPointData()->GetArray("velocity")->GetComponent(node, c), system.v[Index(2 * node)][c]);
      EXPECT_EQ(grid->GetPointData()->GetArray("w")->GetComponent(node, c), system.v[Index(2 * node + 1)][c]);
    }
  }
  EXPECT_EQ(grid->GetPointData()->GetArray("torque")->GetComponent(0, 2), 5);
  EXPECT_GT(std::abs(turns->GetComponent(0, 2)), 0.02) << "it has turned";
  EXPECT_NEAR(turns->GetRange(2)[1], turns->GetComponent(0, 2), 1e-15) << "the range of the last step, not of the first";
}

/// What another component has for each node: numbers, vectors, whole numbers; and what it has not.
TEST_F(Exporter, AttributesOfOtherComponentsComeBack) {
  const auto scene = [this](const std::string& words) {
    return R"(<Node name="root" dt="0.01" gravity="0 0 -9.81"><EulerImplicitSolver newtonIterations="30"/><SparseLDLSolver/>
      <RegularGridTopology name="mesh" n="3 3 3" min="0 0 0.009" max="1 1 1.009"/><MechanicalObject name="state"/>
      <UniformMass totalMass="10"/><HexahedronFEMForceField youngModulus="1e5" poissonRatio="0.3"/>
      <BarrierContact name="contact" contactDistance="0.01" friction="0.3" planes="0 0 1 0"/>)" +
           exporter("pointsDataFields=\"" + words + "\"") + "</Node>";
  };
  Simulation simulation = simulationFromText(scene("contact.pressures pull=contact.contactForces @contact.contactStates"));
  simulation.step();
  const auto grid = read(at("beam00000.vtu"));
  const Component* contact = findComponent(simulation.root(), "/contact");
  const auto* pressures = std::get<std::vector<double>*>(contact->data().find("pressures")->pointer());
  const auto* forces = std::get<std::vector<Vec3>*>(contact->data().find("contactForces")->pointer());
  ASSERT_EQ(pressures->size(), 27u);
  EXPECT_GT((*pressures)[0], 0);
  for (vtkIdType n = 0; n < 27; ++n) {
    EXPECT_EQ(grid->GetPointData()->GetArray("pressures")->GetTuple1(n), (*pressures)[std::size_t(n)]);
    EXPECT_EQ(Vec3(grid->GetPointData()->GetArray("pull")->GetTuple3(n)), (*forces)[std::size_t(n)]);
    EXPECT_EQ(grid->GetPointData()->GetArray("contactStates")->GetTuple1(n), n < 9 ? 1 : 0) << "it sticks below";
  }
  expectContains(problemsOf(scene("contact.pressure")), "did you mean 'pressures'");
  expectContains(problemsOf(scene("contact.stiffness")), "a list of numbers or of vectors");
}

/// The attributes of a state are what it starts with: those of another one would stay as they are for ever.
TEST_F(Exporter, AttributesOfOtherStatesAreRefused) {
  const auto told = [this](const std::string& words) {
    return problemsOf("<Node name='root'><EulerExplicitSolver/><MechanicalObject name='other' position='0 0 0  1 0 0'/>"
                      "<UniformMass totalMass='1'/><Node name='body'><MeshTopology position='0 0 0  1 0 0' edges='0 1'/>"
                      "<MechanicalObject name='own'/><IdentityMapping/>" +
                      exporter("pointsDataFields=\"" + words + "\"") + "</Node></Node>");
  };
  EXPECT_EQ(told("own.velocity"), "");
  for (const char* words : {"other.velocity", "where=/other.position"})
    expectContains(told(words), "pointsDataFields: /other is not of the state that is exported");
}

}  // namespace
}  // namespace stroma::test
