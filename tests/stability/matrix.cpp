// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/stability/matrix.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <random>
#include <regex>
#include <set>
#include <typeindex>

#include "tests/support/force_field_examples.h"

namespace stroma::test::matrix {

const std::vector<Condition>& conditions() {
  static const std::vector<Condition> all{{"inverted", "inverted"},
                                          {"flat", "flat"},
                                          {"line", "line"},
                                          {"point", "point"},
                                          {"random", "random"},
                                          {"E=1", "pulled", 1},
                                          {"E=1e3", "pulled", 1e3},
                                          {"E=1e6", "pulled", 1e6},
                                          {"E=1e9", "pulled", 1e9},
                                          {"nu=0.4999", "pulled", 5000, 0.4999},
                                          {"dt=1e-5", "pulled", 5000, 0.4, 1e-5},
                                          {"dt=1e-3", "pulled", 5000, 0.4, 1e-3},
                                          {"dt=0.1", "pulled", 5000, 0.4, 0.1},
                                          {"dt=1", "pulled", 5000, 0.4, 1},
                                          {"dt=10", "pulled", 5000, 0.4, 10},
                                          {"E=1 dt=10", "pulled", 1, 0.4, 10},
                                          {"E=1e9 dt=1e-5", "pulled", 1e9, 0.4, 1e-5}};
  return all;
}

const std::vector<IntegratorChoice>& integrators() {
  static const std::vector<IntegratorChoice> all{
      {"Euler", "<EulerImplicitSolver name='solver' {}/>"},
      {"Euler, Newton", "<EulerImplicitSolver name='solver' newtonIterations='10' {}/>"},
      {"trapezoid", "<TrapezoidalRuleSolver name='solver' {}/>", false},
      {"trapezoid, Newton", "<TrapezoidalRuleSolver name='solver' newtonIterations='10' {}/>", false},
      {"Newmark", "<NewmarkImplicitSolver name='solver' {}/>", false},
      {"Newmark, Newton", "<NewmarkImplicitSolver name='solver' newtonIterations='10' {}/>", false},
      {"BDF 1", "<BDFOdeSolver name='solver' order='1' {}/>"},
      {"BDF 1, Newton", "<BDFOdeSolver name='solver' order='1' newtonIterations='10' {}/>"},
      {"BDF 2", "<BDFOdeSolver name='solver' order='2' {}/>"},
      {"BDF 2, Newton", "<BDFOdeSolver name='solver' order='2' newtonIterations='10' {}/>"},
      {"midpoint", "<VariationalSymplecticSolver name='solver' steps='1' {}/>", false},
      {"midpoint, Newton", "<VariationalSymplecticSolver name='solver' steps='10' {}/>", false},
      {"static", "<StaticSolver name='solver' newton_iterations='1'/>", true, true},
      {"static, Newton", "<StaticSolver name='solver' newton_iterations='50'/>", true, true}};
  return all;
}

// ---- rows ----

namespace {

constexpr double block_size = 0.2, density = 1000;  // [m], [kg/m^3]

/// The first mode of a bar held at one end: the square root of E / density times pi over twice the length.
double slowestOfBlock(const Condition& c) { return std::sqrt(c.young / density) * 1.5708 / block_size; }

enum class Cells { tetrahedra, boxes, hexahedra };

/// 3 x 3 x 3 nodes, held at four corners that do not lie in a plane. `hexahedra`: the inner node is moved.
std::string block(Cells cells, const std::string& field, const std::string& integrator, const Condition& c) {
  std::string position, corners;
  for (int n = 0; n < 27; ++n) {
    const bool moved = n == 13 && cells == Cells::hexahedra;
    position += fmt::format("{} {} {} ", 0.1 * (n % 3) + (moved ? 0.02 : 0), 0.1 * (n / 3 % 3) - (moved ? 0.015 : 0),
                            0.1 * (n / 9) + (moved ? 0.01 : 0));
  }
  for (int e = 0; e < 8; ++e) {
    const int first = e % 2 + 3 * (e / 2 % 2) + 9 * (e / 4);
    for (int corner : {0, 1, 4, 3, 9, 10, 13, 12}) corners += fmt::format("{} ", first + corner);
  }
  return fmt::format(
      R"(<Node name="root" dt="{}" gravity="0 0 0"><MeshTopology name="mesh" position="{}" hexahedra="{}"/>
  <Node name="body">{}<SparseLDLSolver/>{}<MechanicalObject/><DiagonalMass massDensity="{}"/>
    <{} youngModulus="{}" poissonRatio="{}"/><FixedProjectiveConstraint indices="0 2 6 18"/></Node></Node>)",
      c.dt, position, corners, integrator,
      cells == Cells::tetrahedra ? "<TetrahedronSetTopologyContainer name=\"cells\"/><Hexa2TetraTopologicalMapping "
                                   "input=\"@../mesh\" output=\"@cells\" cutting=\"five\"/>"
                                 : "<HexahedronSetTopologyContainer name=\"cells\" src=\"@../mesh\"/>",
      density, field, c.young, c.poisson);
}

void addBlock(std::vector<Row>& out, Cells cells, const std::string& type, const std::string& variant,
              const std::string& attributes) {
  const char* names[] = {"tetrahedra", "boxes", "hexahedra"};
  const std::string field = type + " " + attributes;
  out.push_back({fmt::format("{} {}", variant.empty() ? type : names[int(cells)], variant), type,
                 [=](const std::string& integrator, const Condition& c) { return block(cells, field, integrator, c); },
                 slowestOfBlock, true, variant.empty()});
}

void addElasticVariants(std::vector<Row>& out, Cells cells) {
  const std::string type = cells == Cells::tetrahedra ? "TetrahedronFEMForceField" : "HexahedronFEMForceField";
  addBlock(out, cells, type, "small", "method=\"small\"");
  addBlock(out, cells, type, "green", "method=\"green\"");
  if (cells == Cells::tetrahedra) addBlock(out, cells, type, "nodal", "method=\"nodal\"");
  for (const std::string method : {"large", "polar", "svd"})
    for (const std::string update : {"", "B", "BV"})
      for (const std::string tangent : {"warped", "exact"})
        addBlock(out, cells, type, method + (update.empty() ? "" : " " + update) + (tangent == "exact" ? " exact" : ""),
                 fmt::format("method=\"{}\" updateStiffnessMatrix=\"{}\" updateVolume=\"{}\" tangent=\"{}\"", method,
                             update != "", update == "BV", tangent));
  for (const std::string update : {"", "B"})
    addBlock(out, cells, type, "polar" + (update.empty() ? "" : " " + update) + " mean dilatation",
             fmt::format("method=\"polar\" updateStiffnessMatrix=\"{}\" dilatation=\"mean\"", update != ""));
}

/// Every number of the attributes `name` (a pattern) times `factor`.
std::string scaled(const std::string& text, const std::string& name, double factor) {
  const std::regex attribute("((?:" + name + ")=\")([^\"]*)\"");
  std::string out;
  auto from = text.cbegin();
  for (std::sregex_iterator it(text.begin(), text.end(), attribute), end; it != end; ++it) {
    std::istringstream numbers((*it)[2]);
    out.append(from, (*it)[0].first);
    out += (*it)[1];
    for (double value; numbers >> value;) out += fmt::format("{} ", value * factor);
    out += "\"";
    from = (*it)[0].second;
  }
  return out + std::string(from, text.cend());
}

/// The example of a manual page without gravity, with another integrator, and with every stiffness, load and damper
/// scaled as E is; what changes over time is held, for the body to have a place of rest. What has no rest shape of its
/// own gets one: a spring to its place for every node of every state.
std::string adapted(std::string text, const std::string& type, const std::string& attributes, bool supported,
                    const std::string& integrator, const Condition& c) {
  const auto replace = [&](const std::string& pattern, const std::string& by) {
    text = std::regex_replace(text, std::regex(pattern), by);
  };
  replace("<(EulerImplicit|EulerExplicit|Static)Solver[^>]*/>", "");
  replace("<[A-Z]*[a-z]*LinearSolver[^>]*/>|<SparseLDLSolver[^>]*/>", "");
  replace("gravity=\"[^\"]*\"", "gravity=\"0 0 0\"");
  replace("n=\"4 4 6\"", "n=\"3 3 4\"");  // shorter runs
  const std::string force = fmt::format("0 {} 0", -0.1 * c.young / 5000);
  replace("times=\"[^\"]*\" forces=\"[^\"]*\"", fmt::format("keyTimes=\"0 1\" forces=\"{0}  {0}\"", force));
  replace("(times|factors|period|pulseMode|pressureSpeed)=\"[^\"]*\"", "");
  replace("dt=\"[^\"]*\"", fmt::format("dt=\"{}\"", c.dt));
  replace("poissonRatio=\"[^\"]*\"", fmt::format("poissonRatio=\"{}\"", c.poisson));
  const double stiffer = c.young / 5000;
  text = scaled(text, "[sS]tiffness|youngModulus|pressure|cauchyStress", stiffer);
  text = scaled(text, "dampingCoefficient", std::sqrt(stiffer));
  if (supported)
    replace("<UniformMass[^>]*/>",
            fmt::format("$&<RestShapeSpringsForceField name=\"support\" stiffness=\"{}\"/>", c.young / 500));
  text.insert(text.find('>') + 1, integrator + "<SparseLDLSolver/>");
  const auto at = text.find("<" + type + " ");
  if (at == std::string::npos) throw std::runtime_error("no " + type + " in its example");
  std::string own = text.substr(at, text.find('>', at) - at);
  const std::regex name("(\\w+)=");
  for (std::sregex_iterator it(attributes.begin(), attributes.end(), name), end; it != end; ++it)
    own = std::regex_replace(own, std::regex("\\b" + (*it)[1].str() + "=\"[^\"]*\""), "");
  own.insert(1 + type.size(), " " + attributes);
  return text.replace(at, text.find('>', at) - at, own);
}

void addExample(std::vector<Row>& out, const std::string& type, const std::string& attributes = {}) {
  static const std::vector<std::string> with_rest_shape{"MeshSpringForceField", "RegularGridSpringForceField",
                                                        "ShapeMemoryForceField", "Phymul",
                                                        "RestShapeSpringsForceField"};
  const bool supported = std::find(with_rest_shape.begin(), with_rest_shape.end(), type) == with_rest_shape.end();
  std::string example = exampleOf(type);
  const std::string named = fieldOf(example, type);
  if (named != type) example = std::regex_replace(example, std::regex("<" + named + " "), "<" + type + " ");
  out.push_back({type + (attributes.empty() ? "" : " " + std::regex_replace(attributes, std::regex("\""), "")) +
                     (supported ? " (supported)" : ""),
                 type,
                 [=](const std::string& integrator, const Condition& c) {
                   return adapted(example, type, attributes, supported, integrator, c);
                 },
                 [](const Condition& c) { return 5 * std::sqrt(c.young / 5000); },
                 example.find("poissonRatio") != std::string::npos, false});
}

/// Hyperelastic tetrahedra that relax, and with a fluid beside.
void addViscousAndPorous(std::vector<Row>& out) {
  const std::string type = "TetrahedronHyperelasticityFEMForceField";
  const std::string viscous = "viscous=\"true\" ParameterAlpha=\"0.235 0.333\" ParameterTau=\"0.05 0.01\" ";
  for (const std::string law : {"NeoHookean", "StableNeoHookean"})
    addBlock(out, Cells::tetrahedra, type, law + " viscous", viscous + "materialName=\"" + law + "\"");
  addBlock(out, Cells::tetrahedra, type, "StableNeoHookean viscous, exponential",
           viscous + "viscousUpdate=\"exponential\" materialName=\"StableNeoHookean\"");
  for (const std::string coupling : {"semi_implicit", "implicit"}) {
    const auto scene = [=](const std::string& integrator, const Condition& c) {
      const std::string fluid = fmt::format(
          "<TetrahedronPorousForceField fluidFraction=\"0.5\" bulkModulus=\"{}\" limitModulus=\"{}\" "
          "permeability=\"{}\" drainedIndices=\"0 2\" coupling=\"{}\"/><Fixed",
          0.1 * c.young, 0.4 * c.young, 0.1 / c.young, coupling);
      return std::regex_replace(
          block(Cells::tetrahedra, type + " " + viscous + "materialName=\"StableNeoHookean\"", integrator, c),
          std::regex("<Fixed"), fluid);
    };
    out.push_back({"tetrahedra StableNeoHookean viscous, porous " + coupling, "TetrahedronPorousForceField", scene,
                   slowestOfBlock, true, false});
  }
}

/// Every law; those without a conversion from youngModulus get parameters of the same size.
void addHyperelasticLaws(std::vector<Row>& out, Cells cells, const std::string& type) {
  const std::pair<const char*, const char*> laws[] = {
      {"StVenantKirchhoff", ""},    {"NeoHookean", ""},
      {"StableNeoHookean", ""},     {"StableNeoHookean", "projectedTangent=\"true\""},
      {"MooneyRivlin", "c2=\"0\""}, {"VerondaWestman", "c2=\"1\""},
      {"ArrudaBoyce", ""},          {"ArrudaBoyce", "projectedTangent=\"true\""},
      {"Ogden", "alpha1=\"5\""}};
  for (const auto& [law, more] : laws)
    addBlock(out, cells, type, fmt::format("{}{}", law, *more && std::string(more)[0] == 'p' ? " projected" : ""),
             fmt::format("materialName=\"{}\" {}", law, more));
  const std::pair<const char*, const char*> anisotropic[] = {
      {"Costa",
       "a=\"{0}\" k0=\"{1}\" bff=\"4\" bfs=\"2\" bss=\"2\" bfn=\"2\" bsn=\"2\" bnn=\"2\" AnisotropyDirections=\"1 1 0 "
       "0 0 1\""},
      {"TransverselyIsotropic", "mu=\"{0}\" lambda=\"{1}\" k1=\"{0}\" k2=\"1\" AnisotropyDirections=\"1 1 0\""}};
  for (const auto& [law, parameters] : anisotropic) {
    const std::string given = parameters, name = law;
    const auto scene = [=](const std::string& integrator, const Condition& c) {
      const double mu = c.young / (2 * (1 + c.poisson)), lambda = 2 * mu * c.poisson / (1 - 2 * c.poisson);
      const std::string own = fmt::format(fmt::runtime(given), mu, lambda);
      return std::regex_replace(block(cells, type + " materialName=\"" + name + "\"", integrator, c),
                                std::regex("youngModulus=\"[^\"]*\" poissonRatio=\"[^\"]*\""), own);
    };
    out.push_back({fmt::format("{} {}", cells == Cells::tetrahedra ? "tetrahedra" : "boxes", name), type, scene,
                   slowestOfBlock, true, false});
  }
}

std::vector<Row> makeRows() {
  std::vector<Row> out;
  addElasticVariants(out, Cells::tetrahedra);
  addElasticVariants(out, Cells::boxes);
  addElasticVariants(out, Cells::hexahedra);
  addViscousAndPorous(out);
  modules().openAll();
  std::set<std::type_index> seen;
  for (const ComponentEntry* entry : factory().entries()) {
    const auto component = factory().make(entry->type);
    if (!dynamic_cast<ForceField*>(component.get())) continue;
    const std::string& type = entry->type;
    const Component& made = *component;
    const bool is_alias = !seen.insert(typeid(made)).second;
    const std::size_t first = out.size();
    if (type == "TetrahedronFEMForceField" || type == "HexahedronFEMForceField") continue;
    if (type == "TetrahedronHyperelasticityFEMForceField" || type == "HexahedronHyperelasticityFEMForceField") {
      addHyperelasticLaws(out, type[0] == 'T' ? Cells::tetrahedra : Cells::boxes, type);
    } else if (component->data().find("thickness")) {
      for (const char* variant : {"method=\"large\" tangent=\"warped\"", "method=\"large\" tangent=\"exact\"",
                                  "method=\"small\" tangent=\"warped\""})
        addExample(out, type, variant);
    } else if (component->data().find("youngModulus")) {
      addBlock(out, type.find("Tetra") != std::string::npos ? Cells::tetrahedra : Cells::boxes, type, "", "");
    } else if (component->data().find("reaction")) {
      for (const char* reaction : {"true", "false", "upright"})
        addExample(out, type, fmt::format("reaction=\"{}\"", reaction));
    } else {
      addExample(out, type);
    }
    for (std::size_t i = first; i < out.size(); ++i) out[i].is_alias = is_alias || out[i].is_alias;
  }
  return out;
}

}  // namespace

const std::vector<Row>& rows() {
  static const std::vector<Row> all = makeRows();
  return all;
}

std::string wordOf(Ending ending) {
  static const char* words[] = {"recovered", "stopped",   "under way", "rings", "kept, said",
                                "grows",     "elsewhere", "moving",    "broken"};
  return words[int(ending)];
}

// ---- one cell ----

namespace {

/// Where an undisturbed body comes to rest, and the slowest of its small motions about that place [rad/s].
struct Rest {
  std::vector<Vec3> position;
  double slowest = 0;
};

class Run {
 public:
  Run(const Row& row, const IntegratorChoice& integrator, const Condition& condition)
      : row_(row), integrator_(integrator), condition_(condition), slowest_(row.slowest(condition)) {}

  Outcome operator()() {
    const Rest& rest = reference();
    target_ = rest.position;
    slowest_ = rest.slowest;
    simulation_ = std::make_unique<Simulation>(sceneFromText(sceneText(integrator_.element, condition_.dt)));
    measure();
    energy_rest_ = restEnergy();
    disturb();
    energy_start_ = energy();
    if (advance(limit())) return outcome_;
    // what neither rests nor stopped may only need more time
    for (int more = 0;; ++more) {
      settle();
      if (outcome_.ending != Ending::moving || more == 3) return outcome_;
      if (advance(limit())) return outcome_;
    }
  }

 private:
  std::string sceneText(const std::string& element, double dt) const {
    const double mass = std::min(2 * slowest_, 0.5 / dt);
    Condition condition = condition_;
    condition.dt = dt;
    return row_.scene(fmt::format(fmt::runtime(element), fmt::format("rayleighMass='{}'", mass)), condition);
  }

  /// Steps until the cell has ended (true) or `steps` are made.
  bool advance(int steps) {
    for (int step = 0, steady = 0; step < steps; ++step) {
      if (!one()) return true;
      steady = distance() < 1e-6 ? steady + 1 : 0;
      if (steady < 5) continue;
      outcome_.steps -= 4;
      ended(Ending::recovered);
      return true;
    }
    return false;
  }

  /// A step; false when the cell has ended with it.
  bool one() {
    ++outcome_.steps;
    const StepReport report = simulation_->step();
    if (!finite())
      ended(Ending::broken, "a position or a velocity is not finite");
    else if (report.diverged)
      stop(report.reason);
    else {
      unsolved_ = report.unsolved ? report.reason : "";
      unconverged_ = report.newton_converged ? "" : report.reason;
      return true;
    }
    return false;
  }

  /// The same for all integrators and starts of a row, so it is kept.
  const Rest& reference() {
    static std::map<std::string, Rest> known;
    Rest& rest = known[fmt::format("{}|{}|{}", row_.name, condition_.young, condition_.poisson)];
    if (!rest.position.empty()) return rest;
    simulation_ = std::make_unique<Simulation>(sceneFromText(sceneText(integrators()[1].element, 0.5 / slowest_)));
    System& s = system();
    Vector before(s.allRows());
    for (int step = 0; step < 2000; ++step) {
      copy(s.x, before);
      simulation_->step();
      axpy(-1, s.x, before);
      if (std::sqrt(dot(before, before)) < 1e-13) break;
    }
    for (Index i = 0; i < s.allRows(); ++i) rest.position.push_back(s.x[i]);
    rest.slowest = slowestAt();
    return rest;
  }

  /// Of the small motions about the place of rest, by inverse iteration on K y = w^2 M y.
  double slowestAt() const {
    System& s = system();
    Vector y(s.rows()), momentum(s.rows());
    for (Index i = 0; i < s.rows(); ++i) y[i] = Vec3(std::sin(1 + i), std::cos(2 * i), std::sin(3 * i));
    s.project(y);
    double squared = 0;
    for (int iteration = 0; iteration < 12; ++iteration) {
      s.computeForce(s.x, s.v, s.f);
      clear(momentum);
      s.addMassProduct(y, 1, momentum);
      s.project(momentum);
      if (!s.linearSolver()->solve(s.matrix({.stiffness = -1}), momentum, y).usable()) return slowest_;
      const double work = dot(y, momentum);
      clear(momentum);
      s.addMassProduct(y, 1, momentum);
      squared = work / dot(y, momentum);
      scale(1 / std::sqrt(dot(y, y)), y);
    }
    return squared > 1e-6 * slowest_ * slowest_ ? std::sqrt(squared) : slowest_;
  }

  void measure() {
    for (const Vec3& p : target_) box_.extend(p);
    size_ = box_.diagonal().norm();
  }
  System& system() const { return *simulation_->systems().at(0); }

  /// The map of the condition on what the constraints leave free.
  void disturb() {
    System& s = system();
    std::vector<Mat3> free(target_.size(), Mat3::Identity());
    for (const NodeProjector& held : s.projectors()) free[std::size_t(held.row)] = held.projector;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    const Vec3 low = box_.min(), extent = box_.sizes(), centre = box_.center();
    for (std::size_t i = 0; i < target_.size(); ++i) {
      const Vec3 p = s.x[Index(i)], noise(uniform(random), uniform(random), uniform(random));
      Vec3 to = p;
      if (condition_.shape == "inverted") to.x() = 2 * centre.x() - p.x();
      if (condition_.shape == "flat") to.z() = centre.z();
      if (condition_.shape == "line") to = Vec3(p.x(), centre.y(), centre.z());
      if (condition_.shape == "point") to = centre;
      if (condition_.shape == "random") to = low + extent.cwiseProduct(noise);
      if (condition_.shape == "pulled")
        to += 0.1 * size_ * Vec3(std::sin(7 * p.y() / size_), (p.z() - low.z()) / size_, std::cos(5 * p.x() / size_)) +
              0.02 * size_ * noise;
      s.x[Index(i)] += free[i] * (to - p);
    }
  }

  /// The slowest motion is critically damped: after 20 / slowest it is 4e-8 of what it was. Where that takes too many
  /// steps a few show whether the energy grows.
  int limit() const {
    if (integrator_.is_static) return 100;
    const double needed = 20 / (slowest_ * condition_.dt);
    return needed > 2500 ? 300 : std::max(200, int(needed));
  }
  bool finite() const {
    for (const State* state : simulation_->states())
      for (Index i = 0; i < state->size(); ++i)
        if (!state->x()[i].allFinite() || !state->v()[i].allFinite()) return false;
    return true;
  }
  double distance() const {
    double worst = 0;
    for (std::size_t i = 0; i < target_.size(); ++i)
      worst = std::max(worst, (system().x[Index(i)] - target_[i]).norm() / size_);
    return worst;
  }
  /// Above that of rest.
  double energy() const { return system().kineticEnergy() + system().potentialEnergy(system().x) - energy_rest_; }
  double restEnergy() const {
    Vector rest(system().allRows());
    for (Index i = 0; i < system().allRows(); ++i) rest[i] = target_[std::size_t(i)];
    return system().potentialEnergy(rest);
  }
  int inverted() const {
    int count = 0;
    for (const ForceField* field : system().forceFields())
      for (const std::string& name : field->cellFields()) {
        std::vector<double> j;
        if (name != "J") continue;
        field->cellField("J", system().x, j);
        count += int(std::count_if(j.begin(), j.end(), [](double value) { return value <= 0; }));
      }
    return count;
  }

  void ended(Ending ending, const std::string& text = {}) {
    outcome_.ending = ending;
    outcome_.text = text;
    if (ending == Ending::elsewhere || ending == Ending::moving || ending == Ending::grows) {
      const auto doubts = simulation_->doubts();
      if (!doubts.empty() || !unconverged_.empty()) {
        outcome_.ending = Ending::kept;
        outcome_.text = doubts.empty() ? unconverged_ : doubts[0];
      }
    }
    outcome_.distance = distance();
    outcome_.inverted = inverted();
  }

  /// A stop must say which step, which component, which element where there are elements, and why.
  void stop(const std::string& reason) {
    std::vector<std::string> words{"/solver: ", fmt::format("step {} ", outcome_.steps)};
    for (const ForceField* field : system().forceFields())
      if (!field->worstElement(system().x).empty()) words.push_back(field->path());
    for (const std::string& word : words)
      if (reason.find(word) == std::string::npos)
        return ended(Ending::broken, fmt::format("no \"{}\" in: {}", word, reason));
    ended(Ending::stopped, reason);
  }

  /// Not at its shape after all steps: at rest elsewhere, too early to tell, or moving?
  void settle() {
    if (!unsolved_.empty()) return stop(unsolved_);
    System& s = system();
    double lowest = distance(), highest = lowest, shift = 0;
    Vector before(s.allRows());
    copy(s.x, before);
    for (int step = 0; step < 10; ++step) {
      if (!one()) return;
      const double now = distance();
      lowest = std::min(lowest, now), highest = std::max(highest, now);
      for (Index i = 0; i < s.allRows(); ++i) shift = std::max(shift, (s.x[i] - before[i]).norm() / size_);
    }
    if (!unsolved_.empty()) return stop(unsolved_);
    const double seconds = simulation_->time(), grown = energy() / energy_start_;
    const double speed = shift / std::max(10 * condition_.dt * slowest_, 1e-12);  // in sizes and slowest periods
    if (integrator_.is_static || (speed < 1e-5 && shift < 1e-7)) return ended(Ending::elsewhere);
    const std::string motion = fmt::format("moves by {:.1e} sizes, energy {:.1e} of the start", shift, grown);
    // what a force without a potential stores may grow while the body comes to rest
    const bool gained = grown > 1 + 1e-6 && (s.isConservative() || highest > 3);
    if (seconds * slowest_ < 20) return ended(gained ? Ending::moving : Ending::under_way, motion);
    if (!integrator_.damps) return ended(highest < 3 && grown < 10 ? Ending::rings : Ending::grows, motion);
    ended(Ending::moving, motion);
  }

  const Row& row_;
  const IntegratorChoice& integrator_;
  const Condition& condition_;
  double slowest_, size_ = 0, energy_start_ = 0, energy_rest_ = 0;
  std::unique_ptr<Simulation> simulation_;
  std::vector<Vec3> target_;
  Eigen::AlignedBox3d box_;
  std::string unsolved_, unconverged_;  ///< sentences of the last step
  Outcome outcome_;
};

}  // namespace

Outcome run(const Row& row, const IntegratorChoice& integrator, const Condition& condition) {
  return Run(row, integrator, condition)();
}

}  // namespace stroma::test::matrix
