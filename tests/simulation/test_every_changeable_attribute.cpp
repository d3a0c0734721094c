// SPDX-License-Identifier: LGPL-2.1-or-later
// Every attribute that may change while a scene runs, of every component of the factory, in the example of its manual
// page: the change has an effect, it has the same one each time, and the run goes on as the same state does in a scene
// that was written with the new value; after a reset it is that of a replay.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "tests/support/force_field_examples.h"
#include "tests/support/scene_text.h"
#include "tools/session/replay.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

constexpr int steps_before = 4, steps_after = 4;

/// A value chosen for the example of `type.attribute`, where none near the present one will do.
std::string chosenValue(const std::string& name) {
  if (name.ends_with(".localStiffnessFactor")) return "0.5";
  if (name.starts_with("SpringForceField.springsIndices")) return "2 0";
  if (name.ends_with("LagrangianConstraint.activate")) return "false";
  if (name == "RestShapeSpringsForceField.targets") return "0.1 0 0  1 0 0.2  2 0.3 0";
  if (name == "RestShapeSpringsForceField.points") return "2 1 0";
  if (name == "SurfacePressureConstraint.maxVolumeGrowth") return "-0.01";
  if (name == "BarrierContact.offset") return "0 0 0.16";  // it has been thrown out of reach
  if (name.ends_with("Contact.offset")) return "0 0 -0.05";  // towards the body it would start too near
  if (name == "BeamHookeLawForceField.innerRadius" || name == "BeamInterpolation.innerRadius") return "0.005";
  if (name == "FormulaForceField.force") return "0; 3 * x; 40 * t";
  return {};
}

/// Why no value of `type.attribute` has an effect in its example; empty: one must have.
std::string exception(const std::string& name) {
  static const std::map<std::string, std::string> reasons = {
      {"AutomaticLinearSolver.iterations", "so few nodes are factored"},
      {"AutomaticLinearSolver.tolerance", "so few nodes are factored"},
      {"BarrierContact.rayleighStiffness", "nothing touches it so soon"},
      {"BoxROI.box", "no step reads the selection; see LiveAttributes"},
      {"BoxROI.orientedBox", "no step reads the selection"},
      {"InterventionalRadiologyController.controlledInstrument", "there is one rod"},
      {"CableConstraint.maxForce", "the cable has been pulled at once, and hangs loose"},
      {"CableConstraint.maxPositiveDisp", "bounds an imposed force, and the example imposes a displacement"},
      {"CableConstraint.maxNegativeDisp", "bounds an imposed force, and the example imposes a displacement"},
      {"CableConstraint.maxDispVariation", "the imposed displacement stays as it is"},
      {"SurfacePressureConstraint.maxPressureVariation", "the imposed pressure stays as it is"},
      {"SurfacePressureConstraint.maxVolumeGrowthVariation", "the example imposes a pressure"},
      {"HexahedronHyperelasticityFEMForceField.ParameterSet", "the example gives parameters by name"},
      {"QuadraticTetrahedronHyperelasticityFEMForceField.ParameterSet", "the example gives parameters by name"},
      {"TetrahedronHyperelasticityFEMForceField.ParameterSet", "the example gives parameters by name"},
      {"TrianglePressureForceField.pressure", "the example gives cauchyStress"},
      {"SpringForceField.spring", "the example lists springs by their ends"},
      {"CGLinearSolver.threshold", "only a solve that breaks down meets it"},
      {"ConstraintSweeps.keepsContactForces", "the example has no contacts"},
      {"ConstantForceField.force", "the example gives totalForce"},
      {"ConstantForceField.forces", "the example gives totalForce"},
      {"ConstantForceField.rayleighStiffness", "no stiffness"},
      {"DiagonalVelocityDampingForceField.rayleighStiffness", "no stiffness"},
      {"EdgePressureForceField.rayleighStiffness", "no stiffness"},
      {"EllipsoidForceField.rayleighStiffness", "nothing touches it so soon"},
      {"FixedPlaneProjectiveConstraint.indices", "the example gives dmin and dmax"},
      {"FormulaForceField.rayleighStiffness", "no stiffness"},
      {"LinearForceField.rayleighStiffness", "no stiffness"},
      {"PlasticStrainForceField.rayleighStiffness", "no stiffness of its own"},
      {"QuadPressureForceField.rayleighStiffness", "no stiffness"},
      {"RestShapeSpringsForceField.angularStiffness", "its nodes are points"},
      {"SphereForceField.rayleighStiffness", "nothing touches it so soon"},
      {"TetrahedronDiffusionFEMForceField.rayleighStiffness", "nothing is damped in steps of first order"},
      {"TorsionForceField.rayleighStiffness", "no stiffness"},
      {"OscillatingTorsionPressureForceField.rayleighStiffness", "no stiffness"},
      {"NewmarkImplicitSolver.undampedStart", "only where a run starts"},
      {"SurfacePressureForceField.pressure", "the far end of a pulse; see LiveAttributes"},
      {"UniformMass.totalMass", "every mass falls alike"},
      {"CarvingRegion.offset", "without observers nothing is carved (view.carving leads one)"},
      {"UniformMass.vertexMass", "every mass falls alike"},
      {"UniformVelocityDampingForceField.rayleighStiffness", "no stiffness"}};
  const auto found = reasons.find(name);
  return found == reasons.end() ? std::string() : found->second;
}

template <class List>
List eachOf(List list, const std::function<double(double)>& changed) {
  for (auto& each : list) each = changed(each);
  return list;
}

/// Values near the present one, then some that are further away.
std::vector<std::string> nearbyValues(const Data& data) {
  std::vector<std::string> values;
  const auto print = [&](auto* value, const auto& other) {
    const auto kept = *value;
    *value = other;
    values.push_back(data.print());
    *value = kept;
  };
  const DataPointer& pointer = data.pointer();
  for (const double factor : {1.25, 0.75, 0.5, 1e4}) {
    const auto scaled = [factor](double number) { return number == 0 ? factor / 50 : factor * number; };
    if (auto* const* real = std::get_if<double*>(&pointer)) print(*real, scaled(**real));
    if (auto* const* list = std::get_if<std::vector<double>*>(&pointer)) print(*list, eachOf(**list, scaled));
    if (auto* const* points = std::get_if<std::vector<Vec3>*>(&pointer)) {
      std::vector<Vec3> moved = **points;
      for (Vec3& point : moved) point = factor * point + Vec3(0.1, 0.2, 0.3);
      print(*points, moved);
    }
    if (auto* const* point = std::get_if<Vec3*>(&pointer)) print(*point, Vec3(factor * **point + Vec3(0.1, 0.2, 0.3)));
  }
  if (auto* const* is = std::get_if<bool*>(&pointer)) print(*is, !**is);
  if (auto* const* each = std::get_if<std::vector<bool>*>(&pointer))
    for (std::size_t i = 0; i < (*each)->size(); ++i) {
      std::vector<bool> other = **each;
      other[i] = !other[i];
      print(*each, other);
    }
  if (const auto* choice = std::get_if<ChoiceRef>(&pointer)) values.insert(values.end(), choice->words.begin(), choice->words.end());
  for (const int number : {2, 1})
    if (auto* const* whole = std::get_if<int*>(&pointer)) print(*whole, number);
  if (auto* const* nodes = std::get_if<std::vector<int>*>(&pointer)) {
    for (const int by : {1, -1}) print(*nodes, eachOf(**nodes, [by](double node) { return node + by; }));
    std::vector<int> fewer = **nodes;
    if (!fewer.empty()) print(*nodes, std::vector<int>(fewer.begin() + 1, fewer.end()));
    for (int node = 0; node < 4; ++node) print(*nodes, std::vector<int>{node});
  }
  return values;
}

/// One attribute of one component of an example.
struct Case {
  std::string type, example, path, attribute;
  std::string name() const { return type + "." + attribute; }
};

std::unique_ptr<Simulation> load(const Case& test, const std::vector<Override>& overrides = {}) {
  auto simulation =
      std::make_unique<Simulation>(loadSceneText(test.example, "test.xml", overrides, factory(), modules()));
  simulation->dropObservers();
  return simulation;
}

/// Hashes of the steps; a step that diverges ends them.
std::vector<std::uint64_t> run(Simulation& simulation, int steps) {
  std::vector<std::uint64_t> hashes;
  while (int(hashes.size()) < steps && !simulation.step().diverged) hashes.push_back(simulation.stateHash());
  return hashes;
}

/// What a value did.
enum class Outcome { refused, without_effect, checked };

Outcome tryValue(const Case& test, const std::string& value, std::string& told) {
  const auto edited = load(test), again = load(test), unedited = load(test);
  for (const auto& each : {edited.get(), again.get(), unedited.get()}) run(*each, steps_before);
  EXPECT_EQ(unedited->steps(), steps_before) << "the example does not run";
  try {
    edited->setAttribute(test.path, test.attribute, value);
  } catch (const ComponentError& error) {
    told += fmt::format("\n  '{}': {}", value, error.what());
    EXPECT_EQ(run(*edited, steps_after), run(*unedited, steps_after)) << "'" << value << "' was refused";
    return Outcome::refused;
  }
  again->setAttribute(test.path, test.attribute, value);
  std::unique_ptr<Simulation> written;
  try {
    written = load(test, {{test.path, test.attribute, value}});
  } catch (const SceneError& error) {
    told += fmt::format("\n  '{}', as written: {}", value, error.diagnostics().text());
    return Outcome::refused;
  }
  written->restore(unedited->checkpoint());
  for (std::size_t i = 0; i < written->systems().size(); ++i) {  // what is newly held has stopped
    copy(edited->systems()[i]->x, written->systems()[i]->x);
    copy(edited->systems()[i]->v, written->systems()[i]->v);
  }
  const auto hashes = run(*edited, steps_after);
  EXPECT_EQ(hashes.size(), std::size_t(steps_after)) << "'" << value << "' ends the run";
  EXPECT_EQ(run(*again, steps_after), hashes) << "'" << value << "' a second time";
  EXPECT_EQ(run(*written, steps_after), hashes) << "the scene written with '" << value << "'";
  edited->reset();
  const auto replayed = load(test);
  replay(*replayed, edited->events());
  EXPECT_EQ(run(*replayed, steps_before), run(*edited, steps_before)) << "'" << value << "', replayed after a reset";
  if (run(*unedited, steps_after) != hashes) return Outcome::checked;
  told += fmt::format("\n  '{}': no effect", value);
  return Outcome::without_effect;
}

void check(const Case& test) {
  const auto scene = load(test);
  std::vector<std::string> values = nearbyValues(*findComponent(scene->root(), test.path)->data().find(test.attribute));
  if (const std::string chosen = chosenValue(test.name()); !chosen.empty()) values = {chosen};
  std::string told;
  for (const std::string& value : values) {
    if (tryValue(test, value, told) == Outcome::checked) {
      EXPECT_EQ(exception(test.name()), "") << "'" << value << "' has an effect";
      return;
    }
  }
  EXPECT_NE(exception(test.name()), "") << "no value has an effect:" << told;
}

/// The example of a manual page, or a beam for what a single element does not show.
std::string sceneFor(const std::string& type, const Component& component) {
  std::string example = exampleOf(type);
  if (dynamic_cast<const Integrator*>(&component) || dynamic_cast<const LinearSolver*>(&component)) {
    const bool steps = dynamic_cast<const Integrator*>(&component);
    const bool iterates = component.data().find("newtonIterations") != nullptr;
    // automatic is another one where the scene writes iterations
    const std::string preconditioner = type == "CGLinearSolver" ? " preconditioner=\"none\"" : "";
    return fmt::format(R"(<Node name="root" dt="0.01" gravity="0 -9.81 0"><{} {}/><{}/>
      <RegularGridTopology n="3 3 5" min="0 0 0" max="0.1 0.1 0.3"/><MechanicalObject/><UniformMass totalMass="1"/>
      <HexahedronFEMForceField youngModulus="2000" poissonRatio="0.3" method="green"/>
      <BoxROI name="roi" box="-1 -1 -0.001 1 1 0.001"/><FixedProjectiveConstraint indices="@roi.indices"/></Node>)",
                       steps ? type : "EulerImplicitSolver",
                       iterates ? "newtonIterations='4' newtonTolerance='1e-10'" : "",
                       steps ? "SparseLDLSolver" : type + preconditioner);
  }
  const auto end = example.rfind("</Node>");
  example.resize(std::min(example.size(), end + 7));
  // damping by the stiffness or the mass needs an implicit step
  for (const std::string explicit_step : {"<EulerExplicitSolver/>", "<EulerExplicitSolver />"})
    if (const auto at = example.find(explicit_step); at != std::string::npos)
      example.replace(at, explicit_step.size(), "<EulerImplicitSolver/><CGLinearSolver tolerance=\"1e-12\"/>");
  return example;
}

std::string withOneSolve(std::string scene) {
  const std::string several = "newtonIterations='4' newtonTolerance='1e-10'";
  if (const auto at = scene.find(several); at != scene.npos) scene.replace(at, several.size(), "newtonIterations='1'");
  return scene;
}

std::vector<Case> cases() {
  modules().openAll();
  std::vector<Case> all;
  for (const ComponentEntry* entry : factory().entries()) {
    const auto component = factory().make(entry->type);
    const std::string scene = sceneFor(entry->type, *component);
    const bool is_named =
        scene.find("<" + entry->type + " ") != scene.npos || scene.find("<" + entry->type + "/") != scene.npos;
    if (!is_named) continue;  // another name of a component that has its own turn
    for (const Data& data : component->data().all())
      if (data.changeEffect() != ChangeEffect::restart)
        all.push_back({entry->type, data.name() == "fromZeroAcceleration" ? withOneSolve(scene) : scene, {}, data.name()});
  }
  return all;
}

TEST(EveryChangeableAttribute, ChangesARunAsASceneWrittenWithItsNewValueGoesOn) {
  const std::vector<Case> all = cases();
  EXPECT_GT(all.size(), 50u);
  for (Case test : all) {
    SCOPED_TRACE(test.name());
    try {
      const auto scene = load(test);
      std::vector<Component*> components;
      scene->root().collect(components);
      for (const Component* component : components)
        if (component->type() == test.type && test.path.empty()) test.path = component->path();
      check(test);
    } catch (const SceneError& error) {
      ADD_FAILURE() << error.diagnostics().text();
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
