// SPDX-License-Identifier: LGPL-2.1-or-later
// Rows, columns and conditions of the stability matrix.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <typeindex>

#include "tests/stability/matrix.h"
#include "tests/support/force_field_examples.h"

namespace stroma::test::matrix {

const std::regex& compiled(const std::string& pattern) {
  static std::map<std::string, std::regex> known;
  const auto found = known.find(pattern);
  return found != known.end() ? found->second : known.emplace(pattern, std::regex(pattern)).first->second;
}

const std::vector<Condition>& conditions() {
  static const std::vector<Condition> all{{"inverted", "inverted"},
                                          {"flat", "flat"},
                                          {"line", "line"},
                                          {"point", "point"},
                                          {"random", "random"},
                                          {"E=1 dt=0.1", "pulled", 1, 0.4, 0.1},
                                          {"E=1e3", "pulled", 1e3},
                                          {"E=1e6", "pulled", 1e6},
                                          {"E=1e9", "pulled", 1e9},
                                          {"nu=0.4999", "pulled", 5000, 0.4999},
                                          {"E=1e7 dt=1e-5", "pulled", 1e7, 0.4, 1e-5},
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
      {"static, Newton", "<StaticSolver name='solver' newton_iterations='50'/>", true, true, true}};
  return all;
}

namespace {

constexpr double block_size = 0.2, density = 1000;  // [m], [kg/m^3]

/// The first mode of a bar held at one end: the square root of E / density times pi over twice the length.
double slowestOfBlock(const Condition& c) { return std::sqrt(c.young / density) * 1.5708 / block_size; }

enum class Cells { tetrahedra, boxes, hexahedra, quadratic };

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
  <Node name="body">{}<SparseLDLSolver/>{}<MechanicalObject{}/><DiagonalMass massDensity="{}"/>
    <{} youngModulus="{}" poissonRatio="{}"/><FixedProjectiveConstraint indices="0 2 6 18"/></Node></Node>)",
      c.dt, position, corners, integrator,
      cells == Cells::quadratic    ? "<Hexa2TetraTopologicalMapping name=\"tets\" input=\"@../mesh\" cutting=\"five\"/>"
                                     "<Linear2QuadraticTopologicalMapping name=\"cells\" input=\"@tets\"/>"
      : cells == Cells::tetrahedra ? "<TetrahedronSetTopologyContainer name=\"cells\"/><Hexa2TetraTopologicalMapping "
                                     "input=\"@../mesh\" output=\"@cells\" cutting=\"five\"/>"
                                   : "<HexahedronSetTopologyContainer name=\"cells\" src=\"@../mesh\"/>",
      cells == Cells::quadratic ? " src=\"@cells\"" : "", density, field, c.young, c.poisson);
}

void addBlock(std::vector<Row>& out, Cells cells, const std::string& type, const std::string& variant,
              const std::string& attributes) {
  const char* names[] = {"tetrahedra", "boxes", "hexahedra", "quadratic"};
  // the rows of the mean name it; the others are those of a volume change at each point
  const bool is_open = type.ends_with("FEMForceField") && attributes.find("dilatation") == std::string::npos;
  const std::string field = type + " " + attributes + (is_open ? " dilatation=\"local\"" : "");
  out.push_back({fmt::format("{} {}", variant.empty() ? type : names[int(cells)], variant), type,
                 [=](const std::string& integrator, const Condition& c) { return block(cells, field, integrator, c); },
                 slowestOfBlock, true, variant.empty()});
  out.back().is_large = cells == Cells::quadratic;
}

void addElasticVariants(std::vector<Row>& out, Cells cells) {
  const bool quadratic = cells == Cells::quadratic;
  const std::string type = quadratic                    ? "QuadraticTetrahedronFEMForceField"
                           : cells == Cells::tetrahedra ? "TetrahedronFEMForceField"
                                                        : "HexahedronFEMForceField";
  addBlock(out, cells, type, "small", "method=\"small\"");
  addBlock(out, cells, type, "green", "method=\"green\"");
  if (cells == Cells::tetrahedra) addBlock(out, cells, type, "nodal", "method=\"nodal\"");
  for (const std::string method : {"large", "polar", "svd"})
    for (const std::string& update : quadratic ? std::vector<std::string>{""} : std::vector<std::string>{"", "B", "BV"})
      for (const std::string tangent : {"warped", "exact"})
        addBlock(out, cells, type, method + (update.empty() ? "" : " " + update) + (tangent == "exact" ? " exact" : ""),
                 fmt::format("method=\"{}\" updateStiffnessMatrix=\"{}\" updateVolume=\"{}\" tangent=\"{}\"", method,
                             update != "", update == "BV", tangent));
  for (const std::string& update : quadratic ? std::vector<std::string>{""} : std::vector<std::string>{"", "B"})
    addBlock(out, cells, type, "polar" + (update.empty() ? "" : " " + update) + " mean dilatation",
             fmt::format("method=\"polar\" updateStiffnessMatrix=\"{}\" dilatation=\"mean\"", update != ""));
}

/// Every number of the attributes `name` (a pattern) times `factor`.
std::string scaled(const std::string& text, const std::string& name, double factor) {
  const std::regex& attribute = compiled("((?:" + name + ")=\")([^\"]*)\"");
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
    text = std::regex_replace(text, compiled(pattern), by);
  };
  replace("<(EulerImplicit|EulerExplicit|Static)Solver[^>]*/>", "");
  replace("<[A-Z]*[a-z]*LinearSolver[^>]*/>|<SparseLDLSolver[^>]*/>", "");
  replace("gravity=\"[^\"]*\"", "gravity=\"0 0 0\"");
  replace("n=\"4 4 6\"", "n=\"3 3 4\"");  // shorter runs
  const std::string force = fmt::format("0 {} 0", -0.1 * c.young / 5000);
  replace("times=\"[^\"]*\" forces=\"[^\"]*\"", fmt::format("keyTimes=\"0 1\" forces=\"{0}  {0}\"", force));
  replace("force=\"[^\"]*;[^\"]*;[^\"]*\"", fmt::format("force=\"0; 0; {}\"", 5 * c.young / 5000));
  replace("(times|factors|period|pulseMode|pressureSpeed)=\"[^\"]*\"", "");
  replace("dt=\"[^\"]*\"", fmt::format("dt=\"{}\"", c.dt));
  replace("poissonRatio=\"[^\"]*\"", fmt::format("poissonRatio=\"{}\"", c.poisson));
  const double stiffer = c.young / 5000;
  const std::string stresses = "[sS]tiffness|[yY]oungModulus|pressure|cauchyStress|traction";
  text = scaled(text, stresses, stiffer);
  text = scaled(text, "dampingCoefficient", std::sqrt(stiffer));
  text = scaled(text, "permeability", 1 / c.relaxationScale());
  if (supported)
    replace("<UniformMass[^>]*/>",
            fmt::format("$&<RestShapeSpringsForceField name=\"support\" stiffness=\"{}\"/>", c.young / 500));
  text.insert(text.find('>') + 1, integrator + "<SparseLDLSolver/>");
  const auto at = text.find("<" + type + " ");
  if (at == std::string::npos) throw std::runtime_error("no " + type + " in its example");
  std::string own = text.substr(at, text.find('>', at) - at);
  const std::regex& name = compiled("(\\w+)=");
  for (std::sregex_iterator it(attributes.begin(), attributes.end(), name), end; it != end; ++it)
    own = std::regex_replace(own, compiled("\\b" + (*it)[1].str() + "=\"[^\"]*\""), "");
  own.insert(1 + type.size(), " " + scaled(attributes, stresses, stiffer));
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

/// [s], of these rows as seen in their runs: creep takes longer than the stresses' own 0.05 s.
constexpr double creep_time = 0.15, drainage_time = 0.5, example_drainage_time = 3;

/// Prony's terms for a condition.
std::string viscous(const Condition& c) {
  return fmt::format(" viscous=\"true\" ParameterAlpha=\"0.235 0.333\" ParameterTau=\"{} {}\" ",
                     0.05 * c.relaxationScale(), 0.01 * c.relaxationScale());
}

/// A row whose stresses relax.
void addViscous(std::vector<Row>& out, Cells cells, const std::string& type, const std::string& name,
                const std::string& attributes) {
  out.push_back({name, type,
                 [=](const std::string& integrator, const Condition& c) {
                   return block(cells, type + viscous(c) + attributes, integrator, c);
                 },
                 slowestOfBlock, true, false, creep_time});
}

/// Cells that relax, with a fluid in them.
void addPorous(std::vector<Row>& out, Cells cells, const std::string& name, const std::string& prefix) {
  for (const std::string coupling : {"semi_implicit", "implicit"}) {
    const auto scene = [=](const std::string& integrator, const Condition& c) {
      const std::string fluid = fmt::format(
          "<{}PorousForceField fluidFraction=\"0.5\" bulkModulus=\"{}\" limitModulus=\"{}\" "
          "permeability=\"{}\" drainedIndices=\"0 2\" coupling=\"{}\"/><Fixed",
          prefix, 0.1 * c.young, 0.4 * c.young, 0.6 / (c.young * c.relaxationScale()), coupling);
      const std::string elastic =
          prefix + "HyperelasticityFEMForceField" + viscous(c) + "materialName=\"StableNeoHookean\"";
      return std::regex_replace(block(cells, elastic, integrator, c), compiled("<Fixed"), fluid);
    };
    out.push_back({name + " StableNeoHookean viscous, porous " + coupling, prefix + "PorousForceField", scene,
                   slowestOfBlock, true, false, drainage_time});
  }
}

/// Hyperelastic tetrahedra that relax, and both kinds of cell with a fluid beside.
void addViscousAndPorous(std::vector<Row>& out) {
  const std::string type = "TetrahedronHyperelasticityFEMForceField";
  for (const std::string law : {"NeoHookean", "StableNeoHookean"})
    addViscous(out, Cells::tetrahedra, type, "tetrahedra " + law + " viscous", "materialName=\"" + law + "\"");
  addViscous(out, Cells::tetrahedra, type, "tetrahedra StableNeoHookean viscous, exponential",
             "viscousUpdate=\"exponential\" materialName=\"StableNeoHookean\"");
  addPorous(out, Cells::tetrahedra, "tetrahedra", "Tetrahedron");
  addPorous(out, Cells::hexahedra, "hexahedra", "Hexahedron");
}

/// Hyperelastic hexahedra with a mean dilatation, and that relax.
void addMeanAndViscousHexahedra(std::vector<Row>& out) {
  const std::string type = "HexahedronHyperelasticityFEMForceField";
  const std::pair<const char*, const char*> laws[] = {
      {"NeoHookean", ""}, {"StableNeoHookean", ""}, {"MooneyRivlin", "c2=\"0\""}, {"Ogden", "alpha1=\"5\""}};
  for (const auto& [law, more] : laws)
    addBlock(out, Cells::boxes, type, fmt::format("{} mean dilatation", law),
             fmt::format("materialName=\"{}\" {} dilatation=\"mean\"", law, more));
  for (const std::string law : {"NeoHookean", "StableNeoHookean"})
    addViscous(out, Cells::boxes, type, "boxes " + law + " viscous", "materialName=\"" + law + "\"");
}

/// Every law; those without a conversion from youngModulus get parameters of the same size. Tetrahedra also with
/// stresses that relax and with the volumetric term regularised.
void addHyperelasticLaws(std::vector<Row>& out, Cells cells, const std::string& type) {
  const std::string body = cells == Cells::tetrahedra  ? "tetrahedra "
                           : cells == Cells::quadratic ? "quadratic "
                                                       : "boxes ";
  const std::pair<const char*, const char*> laws[] = {
      {"StVenantKirchhoff", ""},      {"NeoHookean", ""},  {"StableNeoHookean", ""}, {"MooneyRivlin", "c2=\"0\""},
      {"VerondaWestman", "c2=\"1\""}, {"ArrudaBoyce", ""}, {"Ogden", "alpha1=\"5\""}};
  for (const auto& [law, more] : laws) {
    const std::string attributes = fmt::format("materialName=\"{}\" {} ", law, more), name = law;
    // the laws are the same functions for all cells: of quadratic ones, which take long, one that is finite and one not
    if (cells == Cells::quadratic && name.find("NeoHookean") == std::string::npos) continue;
    addBlock(out, cells, type, law, attributes);
    if (name == "StableNeoHookean" || name == "ArrudaBoyce")
      addBlock(out, cells, type, name + " projected", attributes + "projectedTangent=\"true\"");
    if (cells != Cells::tetrahedra) continue;
    if (name != "StVenantKirchhoff")  // whose energy has no J
      addBlock(out, cells, type, name + " regularised", attributes + "matrixRegularization=\"true\"");
    if (name.find("NeoHookean") == std::string::npos)
      addViscous(out, cells, type, body + name + " viscous", attributes);
  }
  if (cells == Cells::quadratic) return;
  const std::pair<const char*, const char*> anisotropic[] = {
      {"Costa",
       "a=\"{0}\" k0=\"{1}\" bff=\"4\" bfs=\"2\" bss=\"2\" bfn=\"2\" bsn=\"2\" bnn=\"2\" AnisotropyDirections=\"1 1 0 "
       "0 0 1\""},
      {"TransverselyIsotropic", "mu=\"{0}\" lambda=\"{1}\" k1=\"{0}\" k2=\"1\" AnisotropyDirections=\"1 1 0\""}};
  for (const auto& [law, parameters] : anisotropic)
    for (const std::string variant : {"", " regularised", " viscous"}) {
      const bool relaxes = variant == " viscous";
      if (!variant.empty() && cells != Cells::tetrahedra) continue;
      const std::string given = parameters, name = law;
      const auto scene = [=](const std::string& integrator, const Condition& c) {
        const double mu = c.young / (2 * (1 + c.poisson)), lambda = 2 * mu * c.poisson / (1 - 2 * c.poisson);
        const std::string own = fmt::format(fmt::runtime(given), mu, lambda);
        const std::string more = relaxes           ? viscous(c)
                                 : variant.empty() ? std::string()
                                                   : " matrixRegularization=\"true\"";
        return std::regex_replace(block(cells, type + " materialName=\"" + name + "\"" + more, integrator, c),
                                  compiled("youngModulus=\"[^\"]*\" poissonRatio=\"[^\"]*\""), own);
      };
      out.push_back({body + name + variant, type, scene, slowestOfBlock, true, false, relaxes ? creep_time : 0});
    }
}

std::vector<Row> makeRows() {
  std::vector<Row> out;
  addElasticVariants(out, Cells::tetrahedra);
  addElasticVariants(out, Cells::boxes);
  addElasticVariants(out, Cells::hexahedra);
  addElasticVariants(out, Cells::quadratic);
  addViscousAndPorous(out);
  addMeanAndViscousHexahedra(out);
  modules().openAll();
  std::set<std::type_index> seen;
  for (const ComponentEntry* entry : factory().entries()) {
    const auto component = factory().make(entry->type);
    if (!dynamic_cast<ForceField*>(component.get())) continue;
    const std::string& type = entry->type;
    if (type == "BeamFEMForceField" || type == "JointSpringForceField" ||
        type == "FrameSpringForceField") continue;  // of frames: tests/beams
    if (type == "BeamHookeLawForceField") continue;  // linear, of curvatures: tests/sofa
    if (type == "AngularSpringForceField" || type == "GearSpringForceField") continue;  // of frames: tests/springs
    if (type == "InteractionEllipsoidForceField") continue;                             // of frames: tests/loads
    if (type == "TetrahedronDiffusionFEMForceField") continue;  // linear, of numbers: tests/diffusion
    if (type == "LennardJonesForceField") continue;  // rests in many shapes, and a body crushed to a point in another: tests/sofa
    if (type == "TorsionForceField") continue;  // follows the nodes and drives them without end
    if (type == "OscillatingTorsionPressureForceField") continue;  // swings without end
    if (type == "BarrierContact") continue;  // refuses integrators that do not ask it how far they may move: tests/contact
    if (type == "CollisionResponse") continue;  // its contacts are found where a step starts: tests/collision
    const Component& made = *component;
    const bool is_alias = !seen.insert(typeid(made)).second;
    const std::size_t first = out.size();
    const std::string hyperelastic = "HyperelasticityFEMForceField";
    if (type == "TetrahedronFEMForceField" || type == "HexahedronFEMForceField" ||
        type == "QuadraticTetrahedronFEMForceField")
      continue;
    if (type == "Tetrahedron" + hyperelastic || type == "Hexahedron" + hyperelastic ||
        type == "QuadraticTetrahedron" + hyperelastic) {
      addHyperelasticLaws(out,
                          type[0] == 'T'   ? Cells::tetrahedra
                          : type[0] == 'H' ? Cells::boxes
                                           : Cells::quadratic,
                          type);
    } else if (type == "TriangularFEMForceFieldOptim") {  // its strain is of one method and one tangent
      addExample(out, type, "method=\"large\" tangent=\"warped\"");
    } else if (component->data().find("planeStrain")) {
      for (const char* variant : {"method=\"large\" tangent=\"warped\"", "method=\"large\" tangent=\"exact\"",
                                  "method=\"small\" tangent=\"warped\""})
        addExample(out, type, variant);
    } else if (component->data().find("dampingRatio") || type == "TriangularTensorMassForceField" ||
               type == "QuadBendingFEMForceField" || type == "ThinCellsFEMForceField") {  // of surfaces
      addExample(out, type);
    } else if (type == "TriangularAnisotropicFEMForceField") {
      addExample(out, type, "transverseYoungModulus=\"5e3\"");
    } else if (type == "PlasticStrainForceField") {  // what has flowed rests elsewhere: here nothing flows
      addExample(out, type, "plasticYieldThreshold=\"1e9\"");
    } else if (type == "NonUniformHexahedronFEMForceField" || type == "HexahedronCompositeFEMForceField") {
      for (const char* variant : {"method=\"small\"", "method=\"large\"", "method=\"polar\""}) addExample(out, type, variant);
    } else if (component->data().find("youngModulus")) {
      addBlock(out, type.find("Tetra") != std::string::npos ? Cells::tetrahedra : Cells::boxes, type, "", "");
    } else if (component->data().find("reaction")) {
      for (const char* reaction : {"true", "false", "upright"})
        addExample(out, type, fmt::format("reaction=\"{}\"", reaction));
    } else {
      addExample(out, type);
    }
    for (std::size_t i = first; i < out.size(); ++i) {
      out[i].is_alias = is_alias || out[i].is_alias;
      if (type.find("Porous") != std::string::npos) out[i].relaxation = example_drainage_time;
    }
  }
  return out;
}

}  // namespace

const std::vector<Row>& rows() {
  static const std::vector<Row> all = makeRows();
  return all;
}

}  // namespace stroma::test::matrix
