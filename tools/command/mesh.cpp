// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma mesh: a tetrahedral mesh from a segmented image or a closed surface.
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "framework/mesh/labelled_files.h"
#include "framework/mesh/mesh_generator.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/services.h"
#include "framework/scene/whole_file.h"
#include "tools/command/session.h"

namespace fs = std::filesystem;
namespace po = boost::program_options;

namespace stroma::command {
namespace {

const Manual manual{
    "stroma mesh INPUT -o MESH [options]",
    "Fills a body with tetrahedra. INPUT is a segmented volume image (.nii .nii.gz .mhd .mha .vti: one label a voxel, "
    "0 "
    "outside),\nwhich gives one region a label, or a closed surface of triangles (.obj .stl .vtk .vtp), which gives "
    "label 1. MESH is a\n.msh file (the labels are physical groups, and so are the surfaces between them, as "
    "\"soft.bone\" and \"soft.outside\")\nor a .vtu file (cell data `label`). Lengths are in the unit of INPUT after "
    "--scale; a size bounds the radius of the sphere\naround a tetrahedron or triangle, whose edges are about as long. "
    "The same input gives the same file.",
    "  stroma mesh leg.nii.gz -o leg.msh --scale 0.001 --cell-size 0.012 --cell-size 2=0.006\n"
    "  stroma mesh leg.mhd -o leg.msh --name 1=soft --name 2=tibia --json\n"
    "  stroma mesh liver.stl -o liver.vtu --cell-size 0.01 --feature-angle 60\n"};

using Json = nlohmann::ordered_json;

constexpr double poor_angle = 8;      ///< [degrees]
constexpr double poor_volume = 0.01;  ///< relative

/// "3=VALUE" to (3, VALUE); a text without a label before "=" has label 0.
std::pair<int, std::string> labelled(const std::string& option, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {0, text};
  int label = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + equals, label);
  if (error != std::errc() || end != text.data() + equals || label < 1)
    throw UsageError(fmt::format("{} {}: '{}' is not a label (expected LABEL=..., with a label from 1)", option, text,
                                 text.substr(0, equals)));
  return {label, text.substr(equals + 1)};
}

double positive(const std::string& option, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value > 0) || !std::isfinite(value))
    throw UsageError(fmt::format("{} {}: expected a number above 0", option, text));
  return value;
}

struct Request {
  std::string input, output;
  double scale = 1;
  MeshCriteria criteria;
  LabelNames names;
  bool json = false, format_22 = false;
  bool toVtu() const { return output.ends_with(".vtu"); }
};

OptionList optionList() {
  const auto number = [](const char* word) { return po::value<std::string>()->value_name(word); };
  const auto list = [](const char* word) { return po::value<std::vector<std::string>>()->value_name(word); };
  OptionList options("options");
  options.add_options()                                             //
      ("out,o", number("MESH"), "the mesh to write, .msh or .vtu")  //
      ("cell-size", list("[LABEL=]SIZE"),
       "largest size of a tetrahedron, for all labels or for one; may be repeated (default: a twentieth of the longest "
       "side of the body's box)")                                                                            //
      ("facet-size", number("SIZE"), "largest size of a triangle between regions (default: the cell size)")  //
      ("facet-angle", number("DEGREES"), "smallest angle of such a triangle, at most 30 (default 25)")       //
      ("distance", number("LENGTH"),
       "how far such a triangle may be from the surface (default: a tenth of the smallest cell size)")            //
      ("dihedral-angle", number("DEGREES"), "work on cells with a smaller dihedral angle (default 10)")           //
      ("feature-angle", number("DEGREES"), "surfaces: keep edges that are bent by more than this (default: 60)")  //
      ("free-volume",
       "images: leave boundaries where the cells put them, instead of giving each label the volume of "
       "its voxels")                                                                          //
      ("scale", number("FACTOR"), "factor on the positions of INPUT, as 0.001 from mm to m")  //
      ("name", list("LABEL=NAME"), "name of a label in a .msh file; may be repeated")         //
      ("msh22", "write .msh format 2.2 instead of 4.1")                                       //
      ("json", "print the report as JSON");
  return options;
}

void readCriteria(const Values& values, Request& request) {
  MeshCriteria& criteria = request.criteria;
  const auto take = [&values](const char* name, double& to) {
    if (values.count(name)) to = positive(fmt::format("--{}", name), values[name].as<std::string>());
  };
  take("facet-size", criteria.facet_size), take("facet-angle", criteria.facet_angle);
  take("distance", criteria.distance), take("dihedral-angle", criteria.dihedral_angle);
  take("feature-angle", criteria.feature_angle), take("scale", request.scale);
  if (criteria.facet_angle > 30)
    throw UsageError(fmt::format("--facet-angle {}: expected at most 30, beyond which refinement may not end",
                                 criteria.facet_angle));
  if (criteria.dihedral_angle > 30)
    throw UsageError(fmt::format("--dihedral-angle {}: expected at most 30", criteria.dihedral_angle));
  criteria.keep_volume = values.count("free-volume") == 0;
  if (values.count("cell-size"))
    for (const std::string& text : values["cell-size"].as<std::vector<std::string>>()) {
      const auto [label, size] = labelled("--cell-size", text);
      (label ? criteria.label_size[label] : criteria.cell_size) = positive("--cell-size", size);
    }
}

Request readRequest(const Values& values) {
  Request request;
  request.input = required(values, "INPUT", manual);
  request.output = required(values, "out", manual);
  if (!request.toVtu() && !request.output.ends_with(".msh"))
    throw UsageError(fmt::format("-o {}: expected a name that ends with .msh or .vtu", request.output));
  const fs::path folder = fs::absolute(request.output).parent_path();
  if (!fs::is_directory(folder))
    throw UsageError(fmt::format("-o {}: there is no folder {}", request.output, folder.string()));
  readCriteria(values, request);
  if (values.count("name"))
    for (const std::string& text : values["name"].as<std::vector<std::string>>()) {
      const auto [label, name] = labelled("--name", text);
      if (label == 0 || name.empty() || name.find('"') != std::string::npos)
        throw UsageError(fmt::format("--name {}: expected LABEL=NAME", text));
      request.names[label] = name;
    }
  request.json = values.count("json") > 0, request.format_22 = values.count("msh22") > 0;
  return request;
}

/// Sizes that were not given, from the longest side of the body.
void completeSizes(MeshCriteria& criteria, double longest_side, const std::vector<int>& labels) {
  if (!(criteria.cell_size > 0)) criteria.cell_size = longest_side / 20;
  if (criteria.distance > 0) return;
  double smallest = std::numeric_limits<double>::infinity();
  for (const int label : labels) smallest = std::min(smallest, criteria.sizeOf(label));
  criteria.distance = smallest / 10;
}

void checkLabels(const Request& request, const std::vector<int>& labels) {
  const auto check = [&labels](const char* option, int label) {
    if (std::find(labels.begin(), labels.end(), label) != labels.end()) return;
    throw UsageError(
        fmt::format("{} {}=...: the input has no label {} (it has {})", option, label, label, fmt::join(labels, ", ")));
  };
  for (const auto& [label, size] : request.criteria.label_size) check("--cell-size", label);
  for (const auto& [label, name] : request.names) check("--name", label);
}

struct Meshed {
  LabelledMesh mesh;
  std::map<int, double> wanted;  ///< volumes by label, those of the input
  double read_seconds = 0, mesh_seconds = 0;
};

class Clock {
 public:
  double seconds() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

Meshed meshImage(Request& request) {
  Clock clock;
  Meshed out;
  LabelImage image = service<LabelImageReader>()->read(request.input);
  image.origin *= request.scale, image.steps *= request.scale;
  checkLabels(request, image.values);
  completeSizes(request.criteria, image.bodySize().maxCoeff(), image.values);
  const std::vector<long> voxels = image.voxels();
  for (std::size_t i = 0; i < voxels.size(); ++i) out.wanted[image.values[i]] = double(voxels[i]) * image.voxelVolume();
  out.read_seconds = clock.seconds();
  out.mesh = service<MeshGenerator>()->fromImage(image, request.criteria);
  out.mesh_seconds = clock.seconds();
  return out;
}

/// The surface, through the loader of its format.
Mesh readSurface(const Request& request, const char* loader) {
  if (!fs::exists(request.input)) throw ComponentError(fmt::format("there is no file {}", request.input));
  Factory factory;
  Modules modules(factory);
  Diagnostics diagnostics;
  SceneDescription description;
  description.file = "stroma mesh";
  std::string escaped;
  for (const char c : fs::absolute(request.input).string())
    c == '&' ? escaped += "&amp;" : c == '"' ? escaped += "&quot;" : c == '<' ? escaped += "&lt;" : escaped += c;
  description.root = readXml(
      fmt::format("<Node name=\"root\"><{} name=\"surface\" filename=\"{}\" triangulate=\"true\" scale=\"{}\"/></Node>",
                  loader, escaped, request.scale),
      description.file, {}, diagnostics);
  const Scene scene = instantiate(std::move(description), factory, modules, std::move(diagnostics));
  std::vector<MeshLoader*> loaders;
  scene.root->collect(loaders);
  return Mesh(loaders.at(0)->mesh());
}

Meshed meshSurface(Request& request, const char* loader) {
  Clock clock;
  Meshed out;
  const Mesh surface = readSurface(request, loader);
  if (surface.triangles.empty())
    throw ComponentError(fmt::format("{} has no triangles", request.input), "a closed surface");
  checkLabels(request, {1});
  const MeshReport report = surface.report();
  completeSizes(request.criteria, (report.high - report.low).maxCoeff(), {1});
  double volume = 0;
  for (const Triangle& t : surface.triangles)
    volume += tetrahedronVolume(Vec3::Zero(), surface.position[std::size_t(t[0])], surface.position[std::size_t(t[1])],
                                surface.position[std::size_t(t[2])]);
  out.wanted[1] = std::abs(volume);
  out.read_seconds = clock.seconds();
  out.mesh = service<MeshGenerator>()->fromSurface(surface.position, surface.triangles, request.criteria);
  out.mesh_seconds = clock.seconds();
  return out;
}

/// The loader of a surface's format, or null when the name is not a surface's.
const char* surfaceLoader(const std::string& input) {
  if (input.ends_with(".obj")) return "MeshOBJLoader";
  if (input.ends_with(".stl")) return "MeshSTLLoader";
  return input.ends_with(".vtk") || input.ends_with(".vtp") ? "MeshVTKLoader" : nullptr;
}

Json toJson(const Request& request, const Meshed& meshed, const MeshQuality& quality) {
  Json regions = Json::array();
  for (const RegionReport& region : quality.regions)
    regions.push_back({{"label", region.label},
                       {"name", nameOf(region.label, request.names)},
                       {"tetrahedra", region.tetrahedra},
                       {"nodes", region.nodes},
                       {"parts", region.parts},
                       {"volume", region.volume},
                       {"inputVolume", meshed.wanted.at(region.label)},
                       {"watertight", region.watertight()}});
  return {{"mesh", request.output},
          {"nodes", meshed.mesh.position.size()},
          {"tetrahedra", meshed.mesh.tetrahedra.size()},
          {"smallestDihedralAngle", quality.smallest_angle},
          {"largestDihedralAngle", quality.largest_angle},
          {"worstTetrahedron", quality.worst},
          {"cellSize", request.criteria.cell_size},
          {"distance", request.criteria.distance},
          {"readSeconds", meshed.read_seconds},
          {"meshSeconds", meshed.mesh_seconds},
          {"regions", regions}};
}

void print(const Request& request, const Meshed& meshed, const MeshQuality& quality) {
  Vec3 low = meshed.mesh.position.front(), high = low;
  for (const Vec3& p : meshed.mesh.position) low = low.cwiseMin(p), high = high.cwiseMax(p);
  fmt::print("{}: {} nodes, {} tetrahedra, read {:.2f} s, meshed {:.2f} s\n", request.output,
             meshed.mesh.position.size(), meshed.mesh.tetrahedra.size(), meshed.read_seconds, meshed.mesh_seconds);
  fmt::print("box ({:.4g} {:.4g} {:.4g}) to ({:.4g} {:.4g} {:.4g}); cell size {:.4g}, distance {:.4g}\n", low.x(),
             low.y(), low.z(), high.x(), high.y(), high.z(), request.criteria.cell_size, request.criteria.distance);
  const Tetrahedron& worst = meshed.mesh.tetrahedra[std::size_t(quality.worst)];
  fmt::print("dihedral angles {:.2f} to {:.2f} degrees; the worst is tetrahedron {} (nodes {})\n",
             quality.smallest_angle, quality.largest_angle, quality.worst, fmt::join(worst, " "));
  for (const RegionReport& region : quality.regions) {
    const double wanted = meshed.wanted.at(region.label);
    fmt::print("label {} ({}): {} tetrahedra, {} nodes, {} part{}, volume {:.6g} ({:+.2f} % of the input's), {}\n",
               region.label, nameOf(region.label, request.names), region.tetrahedra, region.nodes, region.parts,
               region.parts == 1 ? "" : "s", region.volume, 100 * (region.volume / wanted - 1),
               region.watertight() ? "watertight" : fmt::format("{} edges leak", region.leaking_edges));
  }
}

}  // namespace

int mesh(const Arguments& arguments) {
  const auto values = parseOptions(manual, optionList(), {"INPUT"}, arguments);
  if (!values) return exit_done;
  Request request = readRequest(*values);
  const char* loader = surfaceLoader(request.input);
  const Meshed meshed = loader ? meshSurface(request, loader) : meshImage(request);
  const MeshQuality quality = qualityOf(meshed.mesh);
  writeWholeFile(request.output,
                 request.toVtu() ? vtuText(meshed.mesh) : gmshText(meshed.mesh, request.names, request.format_22));
  if (quality.smallest_angle < poor_angle)
    fmt::print(stderr,
               "warning: the smallest dihedral angle is {:.2f} degrees: another cell size or distance may do better\n",
               quality.smallest_angle);
  for (const RegionReport& region : quality.regions)
    if (const double error = region.volume / meshed.wanted.at(region.label) - 1; std::abs(error) > poor_volume)
      fmt::print(stderr, "warning: the volume of label {} is {:+.1f} % off: a smaller cell size or distance helps\n",
                 region.label, 100 * error);
  if (request.json)
    fmt::print("{}\n", toJson(request, meshed, quality).dump(2, ' ', false, Json::error_handler_t::replace));
  else
    print(request, meshed, quality);
  return exit_done;
}

}  // namespace stroma::command
