// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/mesh_request.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "tools/units/units.h"

namespace stroma::command {
namespace {

const Manual mesh_manual{
    "stroma mesh INPUT -o MESH [options]",
    "Fills a body with tetrahedra. INPUT is a segmented volume image (.nii .nii.gz .mhd .mha .vti: one label a voxel, "
    "0 "
    "outside),\nwhich gives one region per label, or a closed surface of triangles (.obj .stl .vtk .vtp), which gives "
    "label 1. A surface\nthat cuts itself is filled with voxels first (--voxels). MESH is a\n.msh file (the labels are "
    "physical groups, and so are the surfaces between them, as "
    "\"soft.bone\" and \"soft.outside\"; the\nwall of a hollow is \"soft.cavity\", of several \"soft.cavity_1\" and so "
    "on)\nor a .vtu file (cell data `label`). Lengths are in metres with --unit, else "
    "in the unit of INPUT after "
    "--scale; a size bounds the radius of the sphere\naround a tetrahedron or triangle, whose edges are about as long. "
    "The same input gives the same file.",
    "  stroma mesh scenes/meshes/leg.nii.gz -o leg.msh --unit mm --cell-size 0.012 --cell-size 2=0.006\n"
    "  stroma mesh leg.mhd -o leg.msh --name 1=soft --name 2=tibia --json\n"
    "  stroma mesh liver.stl -o liver.vtu --cell-size 0.01 --feature-angle 60\n"
    "  stroma mesh scan.obj -o scan.msh --cell-size 0.01 --voxels 0.0015\n"};

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
      ("voxels", number("SIZE"),
       "surfaces: fill voxels of this size and mesh those, for a surface that cuts or overlaps itself; an eighth of "
       "the "
       "cell size keeps its shape")  //
      ("free-volume",
       "images: leave boundaries where the cells put them, instead of moving them towards the volume of "
       "each label's voxels, as far as the shapes of cells allow")  //
      ("most-cells", number("COUNT"),
       "stop before meshing when more cells are to be expected (default: 5e6; 1e6 take "
       "about a gigabyte and minutes)")                                                                             //
      ("progress", number("SECONDS"), "time between two lines of progress on standard error (default: 5)")          //
      ("scale", number("FACTOR"), "factor on the positions of INPUT, as 0.001 from mm to m")                        //
      ("unit", number("UNIT"), "unit of the positions of INPUT, as mm: they become metres, as with --scale 0.001")  //
      ("name", list("LABEL=NAME"), "name of a label in a .msh file, without '.'; may be repeated")                  //
      ("order", number("1|2"),
       "order of the cells: 2 puts a node in the middle of each edge, for QuadraticTetrahedronFEMForceField (default "
       "1)")                                             //
      ("msh22", "write .msh format 2.2 instead of 4.1")  //
      ("json", "print the report as JSON");
  return options;
}

/// The length of a unit [m].
double metresOf(const std::string& option, const std::string& name) {
  try {
    return inSI(1, readLengthUnit(name));
  } catch (const ComponentError& error) {
    const std::string nearest = error.suggestion.empty() ? "" : fmt::format("; did you mean '{}'?", error.suggestion);
    throw UsageError(fmt::format("{} {}: expected {}{}", option, name, error.expected, nearest));
  }
}

/// A number above zero, with a unit where positions become metres: "3 mm".
double length(const Values& values, const std::string& option, const std::string& text) {
  const std::size_t end = text.find_last_not_of("abcdefghijklmnopqrstuvwxyz ");
  if (end == std::string::npos || end + 1 == text.size()) return positive(option, text);
  const double number = positive(option, text.substr(0, end + 1));
  if (!values.count("unit"))
    throw UsageError(fmt::format("{} {}: expected a number without a unit: that of INPUT is not known without --unit", option, text));
  return number * metresOf(option, text.substr(text.find_first_not_of(' ', end + 1)));
}

void readCriteria(const Values& values, MeshRequest& request) {
  MeshCriteria& criteria = request.criteria;
  const auto take = [&values](const char* name, double& to) {
    if (values.count(name)) to = positive(fmt::format("--{}", name), values[name].as<std::string>());
  };
  const auto takeLength = [&values](const char* name, double& to) {
    if (values.count(name)) to = length(values, fmt::format("--{}", name), values[name].as<std::string>());
  };
  takeLength("facet-size", criteria.facet_size), take("facet-angle", criteria.facet_angle);
  takeLength("distance", criteria.distance), take("dihedral-angle", criteria.dihedral_angle);
  take("feature-angle", criteria.feature_angle), take("scale", request.scale);
  if (values.count("unit") && values.count("scale")) throw UsageError("--unit and --scale: expected one of them");
  if (values.count("unit")) request.scale = metresOf("--unit", values["unit"].as<std::string>());
  request.has_metres = values.count("unit") > 0;
  takeLength("voxels", request.voxels), take("most-cells", request.most_cells), take("progress", request.progress);
  if (criteria.facet_angle > 30)
    throw UsageError(fmt::format("--facet-angle {}: expected at most 30, beyond which refinement may not end",
                                 criteria.facet_angle));
  if (criteria.dihedral_angle > 30)
    throw UsageError(fmt::format("--dihedral-angle {}: expected at most 30", criteria.dihedral_angle));
  if (criteria.feature_angle > 180)
    throw UsageError(fmt::format("--feature-angle {}: expected degrees, at most 180", criteria.feature_angle));
  criteria.keep_volume = values.count("free-volume") == 0;
  if (values.count("cell-size"))
    for (const std::string& text : values["cell-size"].as<std::vector<std::string>>()) {
      const auto [label, size] = labelled("--cell-size", text);
      double& to = label ? criteria.label_size[label] : criteria.cell_size;
      if (to > 0) throw UsageError(fmt::format("--cell-size {}: there is another one before it", text));
      to = length(values, "--cell-size", size);
    }
}

void readNames(const Values& values, MeshRequest& request) {
  if (!values.count("name")) return;
  for (const std::string& text : values["name"].as<std::vector<std::string>>()) {
    const auto [label, name] = labelled("--name", text);
    if (label == 0 || name.empty() || name.find('"') != std::string::npos)
      throw UsageError(fmt::format("--name {}: expected LABEL=NAME", text));
    if (name.find('.') != std::string::npos)
      throw UsageError(
          fmt::format("--name {}: a '.' joins the names of two labels to that of the surface between them", text));
    if (name == "outside") throw UsageError(fmt::format("--name {}: 'outside' is the exterior of the body", text));
    if (!request.names.emplace(label, name).second)
      throw UsageError(fmt::format("--name {}: label {} has a name, '{}'", text, label, request.names[label]));
  }
}

/// Options that this input or output has no use for.
void refuseIdle(const Values& values, const MeshRequest& request) {
  const auto refuse = [&values](const char* name, const char* use) {
    if (values.count(name)) throw UsageError(fmt::format("--{} has no effect here: it is for {}", name, use));
  };
  if (!request.surfaceLoader()) refuse("voxels", "surfaces (an image has its own)");
  if (request.surfaceLoader() && request.voxels == 0)
    refuse("free-volume", "images, whose voxels give a volume (a surface is kept unchanged)");
  else
    refuse("feature-angle", "surfaces, whose edges can be kept (images and voxels have none)");
  if (request.toVtu()) {
    refuse("name", ".msh files (a .vtu file has numbers only)");
    refuse("msh22", ".msh files");
  }
}

MeshRequest readRequest(const Values& values) {
  MeshRequest request;
  request.input = required(values, "INPUT", mesh_manual);
  if (!values.count("out"))
    throw UsageError(fmt::format("the mesh to write is missing (expected -o MESH, as -o leg.msh); usage: {}", mesh_manual.usage));
  request.output = values["out"].as<std::string>();
  if (!request.toVtu() && !request.output.ends_with(".msh"))
    throw UsageError(fmt::format("-o {}: expected a name that ends with .msh or .vtu", request.output));
  const fs::path folder = fs::absolute(request.output).parent_path();
  if (!fs::is_directory(folder))
    throw UsageError(fmt::format("-o {}: there is no folder {}", request.output, folder.string()));
  readCriteria(values, request);
  readNames(values, request);
  refuseIdle(values, request);
  if (values.count("order")) {
    const std::string order = values["order"].as<std::string>();
    if (order != "1" && order != "2") throw UsageError(fmt::format("--order {}: expected 1 or 2", order));
    request.order = order == "2" ? 2 : 1;
  }
  request.json = values.count("json") > 0, request.format_22 = values.count("msh22") > 0;
  return request;
}

}  // namespace

const char* MeshRequest::surfaceLoader() const {
  if (input.ends_with(".obj")) return "MeshOBJLoader";
  if (input.ends_with(".stl")) return "MeshSTLLoader";
  return input.ends_with(".vtk") || input.ends_with(".vtp") ? "MeshVTKLoader" : nullptr;
}

CommandLine meshLine() { return {mesh_manual, optionList(), {"INPUT"}}; }

std::optional<MeshRequest> readMeshRequest(const Arguments& arguments) {
  const auto values = parseOptions(meshLine(), arguments);
  if (!values) return {};
  return readRequest(*values);
}

void checkLabels(const MeshRequest& request, const std::vector<int>& labels) {
  const auto check = [&labels](const char* option, int label) {
    if (std::find(labels.begin(), labels.end(), label) != labels.end()) return;
    throw UsageError(
        fmt::format("{} {}=...: the input has no label {} (it has {})", option, label, label, fmt::join(labels, ", ")));
  };
  for (const auto& [label, size] : request.criteria.label_size) check("--cell-size", label);
  for (const auto& [label, name] : request.names) check("--name", label);
  std::map<std::string, int> owner;
  for (const int label : labels) {
    const auto [entry, is_new] = owner.emplace(nameOf(label, request.names), label);
    if (!is_new)
      throw UsageError(
          fmt::format("--name {}={}: labels {} and {} would have one name", label, entry->first, entry->second, label));
  }
}

}  // namespace stroma::command
