// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes the mesh of a body as it moves, for ParaView: one .vtu file (binary) for each export, and one .pvd file that
// lists them with their times.
//
// The files are filename00000.vtu, filename00001.vtu, ..., relative to the working directory; the folder is made when
// it is missing. overwrite="true" keeps one file, filename.vtu. XMLformat="false" writes legacy .vtk files (ParaView
// orders them by number; no .pvd). Each file appears complete or not at all, and the .pvd is valid after every export.
//
// Unlike SOFA an export is made at every step unless exportEveryNumberOfSteps says otherwise, and the cells of the
// highest dimension are written unless edges, triangles, quads, tetras or hexas says otherwise.
//
// Fields are words `what` or `label=what`. pointsDataFields: position, restPosition, displacement, velocity, force (or
// `state.velocity`). cellsDataFields: a cell field of a force field of the same node, `vonMises`, `fem.vonMises` or
// `@../body/fem.vonMises`; cells that the force field does not have get NaN.
//
// Source: the attributes are SOFA's; the formats are VTK's.
//
// Example:
// <Node name="root">
//   <RegularGridTopology name="grid" n="3 2 2" min="0 0 0" max="2 1 1"/>
//   <MechanicalObject name="state"/>
//   <VTKExporter filename="grid" pointsDataFields="velocity" exportAtBegin="true"/>
// </Node>
#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <filesystem>
#include <limits>

#include "framework/mechanics/force_field.h"
#include "framework/mesh/topology.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/whole_file.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

namespace fs = std::filesystem;

enum class PointField { position, rest_position, displacement, velocity, force };
const std::vector<std::string> point_field_words{"position", "restPosition", "displacement", "velocity", "force"};

class VTKExporter : public Observer {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void begin(const Simulation& simulation) override;
  void afterStep(const Simulation& simulation, const StepContext&) override;
  bool readsAllNodes(const StepContext& context) const override {
    return enable_ && every_ > 0 && context.index % every_ == 0;
  }
  void end(const Simulation& simulation) override;
  void serialize(Archive& archive) override;
  std::string describe() const override;

 private:
  struct PointOutput {
    std::string label;
    PointField what;
    vtkSmartPointer<vtkDoubleArray> values;
  };
  struct CellOutput {
    std::string label, field;
    ForceField* source;
    vtkSmartPointer<vtkDoubleArray> values;
  };

  void chooseCells();
  void makeGrid();
  void addPointField(const std::string& word);
  void addCellField(const std::string& word);
  ForceField& forceFieldWith(const std::string& field) const;
  Component& componentAt(std::string_view path) const;
  std::vector<double> fieldOfCells(const CellOutput& output) const;
  void fill();
  void write(const Simulation& simulation);
  std::string contents() const;
  void writeCollection() const;
  vtkSmartPointer<vtkDoubleArray> newArray(const std::string& label, int components) const;

  FileName filename_;
  Link<State> mstate_{"mechanical state"};
  Link<Topology> topology_link_{"topology"};
  std::vector<Vec3> position_;
  std::vector<std::string> point_words_, cell_words_;
  int every_ = 1;
  bool at_begin_ = false, at_end_ = false, enable_ = true, xml_ = true, overwrite_ = false;
  bool edges_ = false, triangles_ = false, quads_ = false, tetras_ = true, hexas_ = true;

  State* state_ = nullptr;
  const Topology* topology_ = nullptr;
  const System* system_ = nullptr;
  fs::path stem_;
  vtkSmartPointer<vtkUnstructuredGrid> grid_;
  vtkSmartPointer<vtkDoubleArray> points_, time_;
  std::vector<PointOutput> point_outputs_;
  std::vector<CellOutput> cell_outputs_;
  std::vector<std::pair<double, std::string>> written_;  ///< time [s] and name of each file
  long last_step_ = -1;
};

void VTKExporter::declare(DataTable& table) {
  table.add("filename", filename_).help("start of the names of the files; default: the component's name");
  table.add("exportEveryNumberOfSteps", every_).help("steps from one export to the next; 0: none").min(0);
  table.add("exportAtBegin", at_begin_).help("export the initial state");
  table.add("exportAtEnd", at_end_).help("export the last state, also when the run stops between two exports");
  table.add("enable", enable_).help("export at all");
  table.add("XMLformat", xml_).help("write .vtu and .pvd; false: legacy .vtk");
  table.add("overwrite", overwrite_).help("keep one file instead of a series");
  table.add("edges", edges_).help("write edges");
  table.add("triangles", triangles_).help("write triangles");
  table.add("quads", quads_).help("write quads");
  table.add("tetras", tetras_).help("write tetrahedra");
  table.add("hexas", hexas_).help("write hexahedra");
  table.add("pointsDataFields", point_words_).help("fields of the nodes");
  table.add("cellsDataFields", cell_words_).help("fields of the cells");
  table.add("position", position_)
      .unit("m")
      .help("positions of the state, for SOFA's scenes; those are always written");
  table.addLink("topology", topology_link_).help("the mesh; default: that of the node or above");
  table.addLink("mstate", mstate_).help("the state; default: that of the node or above");
}

void VTKExporter::init() {
  state_ = mstate_.target() ? mstate_.get() : find<State>(true);
  if (!state_)
    throw ComponentError("there is no state to export", "a MechanicalObject in the node or above, or mstate");
  topology_ = topology_link_.target() ? topology_link_.get() : find<Topology>(true);
  if (!topology_) throw ComponentError("there is no mesh to export", "a topology in the node or above, or topology");
  if (topology_->mesh().nodes() != state_->size())
    throw ComponentError(fmt::format("{} has {} nodes, but {} has {}", topology_->path(), topology_->mesh().nodes(),
                                     state_->path(), state_->size()),
                         "a mesh and a state of one size");
  if (!position_.empty() && Index(position_.size()) != state_->size())
    throw ComponentError(fmt::format("position has {} values, but the state has {}", position_.size(), state_->size()));
  if (enable_ && every_ == 0 && !at_begin_ && !at_end_)
    warn("nothing will be written", "exportEveryNumberOfSteps, exportAtBegin or exportAtEnd");
  stem_ = fs::path(filename_.empty() ? name() : filename_.given);
  if (stem_.extension() == ".vtu" || stem_.extension() == ".vtk" || stem_.extension() == ".pvd")
    stem_.replace_extension();
  chooseCells();
  makeGrid();
  for (const std::string& word : point_words_) addPointField(word);
  for (const std::string& word : cell_words_) addCellField(word);
}

void VTKExporter::chooseCells() {
  for (const char* name : {"edges", "triangles", "quads", "tetras", "hexas"})
    if (data().find(name)->isSet()) return;
  const Mesh& mesh = topology_->mesh();
  if (!mesh.tetrahedra.empty() || !mesh.hexahedra.empty()) return;
  const bool faces = !mesh.triangles.empty() || !mesh.quads.empty();
  triangles_ = quads_ = faces;
  edges_ = !faces;
}

void VTKExporter::makeGrid() {
  const Mesh& mesh = topology_->mesh();
  grid_ = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid_->Allocate(vtkIdType(mesh.tetrahedra.size() + mesh.hexahedra.size()));
  const auto add = [this](bool wanted, int type, const auto& cells) {
    if (!wanted) return;
    for (const auto& cell : cells) {
      std::array<vtkIdType, 8> ids{};
      std::copy(cell.begin(), cell.end(), ids.begin());
      grid_->InsertNextCell(type, vtkIdType(cell.size()), ids.data());
    }
  };
  add(tetras_, VTK_TETRA, mesh.tetrahedra);
  add(hexas_, VTK_HEXAHEDRON, mesh.hexahedra);
  add(triangles_, VTK_TRIANGLE, mesh.triangles);
  add(quads_, VTK_QUAD, mesh.quads);
  add(edges_, VTK_LINE, mesh.edges);
  if (grid_->GetNumberOfCells() == 0) warn("no cell will be written: the mesh has none of the kinds asked for");
  points_ = vtkSmartPointer<vtkDoubleArray>::New();
  points_->SetNumberOfComponents(3);
  points_->SetNumberOfTuples(state_->size());
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetData(points_);
  grid_->SetPoints(points);
  time_ = vtkSmartPointer<vtkDoubleArray>::New();
  time_->SetName("TimeValue");
  time_->SetNumberOfTuples(1);
  grid_->GetFieldData()->AddArray(time_);
}

vtkSmartPointer<vtkDoubleArray> VTKExporter::newArray(const std::string& label, int components) const {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(label.c_str());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(components == 3 ? vtkIdType(state_->size()) : grid_->GetNumberOfCells());
  return array;
}

void VTKExporter::addPointField(const std::string& word) {
  const std::size_t equals = word.find('=');
  std::string what = equals == std::string::npos ? word : word.substr(equals + 1);
  if (const std::size_t dot = what.rfind('.'); dot != std::string::npos) {
    const Component& owner = componentAt(what.substr(0, dot));
    if (&owner != state_)
      throw ComponentError(fmt::format("pointsDataFields: '{}' is not of the state that is exported", word),
                           fmt::format("a field of {}", state_->path()));
    what = what.substr(dot + 1);
  }
  if (what == "rest_position") what = "restPosition";  // SOFA's name of the attribute
  const auto found = std::find(point_field_words.begin(), point_field_words.end(), what);
  if (found == point_field_words.end())
    throw ComponentError(fmt::format("pointsDataFields: '{}' is not a field of nodes", what),
                         "position, restPosition, displacement, velocity or force", nearest(what, point_field_words));
  const std::string label = equals == std::string::npos ? what : word.substr(0, equals);
  const PointField field = PointField(found - point_field_words.begin());
  if (field == PointField::force) state_->requestForce();
  point_outputs_.push_back({label, field, newArray(label, 3)});
  grid_->GetPointData()->AddArray(point_outputs_.back().values);
}

void VTKExporter::addCellField(const std::string& word) {
  const std::size_t equals = word.find('=');
  const std::string what = equals == std::string::npos ? word : word.substr(equals + 1);
  const std::size_t dot = what.rfind('.');
  const bool names_owner = dot != std::string::npos && dot > what.rfind('/') + 1;
  ForceField* source = nullptr;
  if (names_owner) {
    Component& owner = componentAt(what.substr(0, dot));
    source = dynamic_cast<ForceField*>(&owner);
    if (!source) throw ComponentError(fmt::format("cellsDataFields: {} is not a force field", owner.path()));
  } else {
    source = &forceFieldWith(what);
  }
  source->ensureReady();
  const std::string field = names_owner ? what.substr(dot + 1) : what;
  const auto known = source->cellFields();
  if (std::find(known.begin(), known.end(), field) == known.end())
    throw ComponentError(
        fmt::format("cellsDataFields: {} has no field '{}'", source->path(), field),
        known.empty() ? "a force field with cell fields" : fmt::format("one of {}", fmt::join(known, ", ")),
        nearest(field, known));
  const std::string label = equals == std::string::npos ? field : word.substr(0, equals);
  cell_outputs_.push_back({label, field, source, newArray(label, 1)});
  grid_->GetCellData()->AddArray(cell_outputs_.back().values);
}

/// The only force field of the node and below that has the cell field.
ForceField& VTKExporter::forceFieldWith(const std::string& field) const {
  std::vector<ForceField*> all, matching;
  node().collect(all);
  std::vector<std::string> names;
  for (ForceField* candidate : all)
    for (const std::string& name : candidate->cellFields()) {
      names.push_back(name);
      if (name == field) matching.push_back(candidate);
    }
  if (matching.size() != 1)
    throw ComponentError(fmt::format("cellsDataFields: {} force fields of the node have '{}'", matching.size(), field),
                         "component.field", matching.empty() ? nearest(field, names) : std::string{});
  return *matching.front();
}

/// "fem" (here, else in the nearest node above), "@fem", "@../body/fem", "@/body/fem".
Component& VTKExporter::componentAt(std::string_view path) const {
  const std::string whole(path);
  if (path.starts_with('@')) path.remove_prefix(1);
  Node* at = &node();
  if (path.starts_with('/')) {
    at = &node().root();
    path.remove_prefix(1);
  }
  for (std::size_t slash = path.find('/'); at && slash != std::string_view::npos; slash = path.find('/')) {
    const std::string_view part = path.substr(0, slash);
    if (part == "..")
      at = at->parent();
    else if (part != ".")
      at = at->findChild(part);
    path.remove_prefix(slash + 1);
  }
  const bool name_only = whole.find('/') == std::string::npos;
  Component* found = at ? at->findByName(path) : nullptr;
  for (; !found && name_only && at->parent(); found = at->findByName(path)) at = at->parent();
  if (!found) throw ComponentError(fmt::format("there is no component '{}'", whole), "a path like fem or @../body/fem");
  return *found;
}

void VTKExporter::begin(const Simulation& simulation) {
  system_ = nullptr;
  for (const auto& system : simulation.systems())
    for (const State* state : system->states())
      if (state == state_) system_ = system.get();
  if (simulation.steps() == 0) written_.clear(), last_step_ = -1;
  if (enable_ && stem_.has_parent_path()) fs::create_directories(stem_.parent_path());
  if (enable_ && at_begin_ && simulation.steps() == 0) write(simulation);
}

void VTKExporter::afterStep(const Simulation& simulation, const StepContext&) {
  if (enable_ && every_ > 0 && simulation.steps() % every_ == 0) write(simulation);
}

void VTKExporter::end(const Simulation& simulation) {
  if (enable_ && at_end_ && last_step_ != simulation.steps()) write(simulation);
}

/// The files of the run so far: a series goes on with the next number.
void VTKExporter::serialize(Archive& archive) {
  std::size_t count = written_.size();
  archive.value("last_step", last_step_);
  archive.value("files", count);
  written_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    archive.value("time " + std::to_string(i), written_[i].first);
    archive.value("name " + std::to_string(i), written_[i].second);
  }
}

std::string VTKExporter::describe() const {
  if (!enable_) return "writes nothing (enable=\"false\")";
  const std::string file = fmt::format("{}{}.{}", stem_.string(), overwrite_ ? "" : "NNNNN", xml_ ? "vtu" : "vtk");
  return fmt::format("writes {} {}{}{}", file, every_ == 0 ? "never" : fmt::format("every {} steps", every_),
                     at_begin_ ? ", at the begin" : "", at_end_ ? ", at the end" : "");
}

void VTKExporter::fill() {
  const bool bound = state_->isBound();
  for (Index n = 0; n < state_->size(); ++n) {
    const Vec3 x = bound ? Vec3(state_->x()[n]) : state_->position[n];
    std::copy(x.data(), x.data() + 3, points_->GetPointer(3 * vtkIdType(n)));
    for (PointOutput& output : point_outputs_) {
      Vec3 value = x;
      if (output.what == PointField::rest_position) value = state_->rest_position[n];
      if (output.what == PointField::displacement) value = x - state_->rest_position[n];
      if (output.what == PointField::velocity) value = bound ? Vec3(state_->v()[n]) : state_->velocity[n];
      if (output.what == PointField::force) value = bound ? Vec3(state_->f()[n]) : Vec3(Vec3::Zero());
      std::copy(value.data(), value.data() + 3, output.values->GetPointer(3 * vtkIdType(n)));
    }
  }
  for (CellOutput& output : cell_outputs_) {
    const std::vector<double> values = fieldOfCells(output);
    std::copy(values.begin(), values.end(), output.values->GetPointer(0));
    output.values->Modified();
  }
  points_->Modified();
}

/// One value for each written cell. A force field fills the tetrahedra or the hexahedra of its mesh, or both in turn.
std::vector<double> VTKExporter::fieldOfCells(const CellOutput& output) const {
  std::vector<double> values;
  if (!system_) throw std::runtime_error(fmt::format("{}: cell fields need a state that an integrator moves", path()));
  output.source->cellField(output.field, system_->x, values);
  const Mesh& mesh = topology_->mesh();
  const std::size_t tetras = mesh.tetrahedra.size(), hexas = mesh.hexahedra.size();
  std::vector<double> out(std::size_t(grid_->GetNumberOfCells()), std::numeric_limits<double>::quiet_NaN());
  const auto place = [&](std::size_t from, std::size_t count, std::size_t to) {
    std::copy_n(values.begin() + std::ptrdiff_t(from), count, out.begin() + std::ptrdiff_t(to));
  };
  const std::size_t first_hexa = tetras_ ? tetras : 0;
  if (values.size() == tetras + hexas) {
    if (tetras_) place(0, tetras, 0);
    if (hexas_) place(tetras, hexas, first_hexa);
  } else if (values.size() == tetras) {
    if (tetras_) place(0, tetras, 0);
  } else if (values.size() == hexas) {
    if (hexas_) place(0, hexas, first_hexa);
  } else {
    throw std::runtime_error(
        fmt::format("{}: {} gives {} values of '{}', but the mesh has {} tetrahedra and {} hexahedra", path(),
                    output.source->path(), values.size(), output.field, tetras, hexas));
  }
  return out;
}

void VTKExporter::write(const Simulation& simulation) {
  fill();
  time_->SetValue(0, simulation.time());
  const std::string number = overwrite_ ? "" : fmt::format("{:05}", written_.size());
  const fs::path file = stem_.string() + number + (xml_ ? ".vtu" : ".vtk");
  writeWholeFile(file.string(), contents());
  if (overwrite_) written_.clear();
  written_.emplace_back(simulation.time(), file.filename().string());
  last_step_ = simulation.steps();
  if (xml_) writeCollection();
}

std::string VTKExporter::contents() const {
  if (xml_) {
    const auto writer = vtkSmartPointer<vtkXMLUnstructuredGridWriter>::New();
    writer->SetInputData(grid_);
    writer->SetWriteToOutputString(true);
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetCompressorTypeToNone();
    writer->Write();
    return writer->GetOutputString();
  }
  const auto writer = vtkSmartPointer<vtkUnstructuredGridWriter>::New();
  writer->SetInputData(grid_);
  writer->WriteToOutputStringOn();
  writer->SetFileTypeToBinary();
  writer->Write();
  return writer->GetOutputStdString();
}

void VTKExporter::writeCollection() const {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  "
      "<Collection>\n";
  for (const auto& [time, file] : written_)
    text += fmt::format("    <DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>\n", time, file);
  writeWholeFile(stem_.string() + ".pvd", text + "  </Collection>\n</VTKFile>\n");
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(vtk_exporter) {
  factory.add<stroma::VTKExporter>("VTKExporter", "writes the moving mesh and its fields for ParaView");
}
