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
// Rigid frames are points with the array "orientation" (x y z w), by which ParaView turns glyphs; without a mesh each is a
// vertex.
//
// Fields are words `what` or `label=what`. pointsDataFields: position, restPosition, displacement, velocity, force (or
// `state.velocity`), of frames also angularVelocity and torque, and what another component has for each node, `contact.pressures` or
// `pull=@../contact.contactForces`; not those of another state. cellsDataFields: a cell field of a force field of the same
// node, `vonMises` or `fem.vonMises`, or of another one, `liver=@../body/fem.vonMises`; cells that the force field does
// not have get NaN. Tensors (`stress`, Cauchy's, and `strain`) have six numbers per cell: xx yy zz xy yz zx, which ParaView
// takes for a symmetric tensor. `principalStress` and `principalStrain` have three, the largest first.
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
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <limits>

#include "components/vtk_io/field_word.h"
#include "components/vtk_io/point_fields.h"
#include "components/vtk_io/vtk_series.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

/// SOFA's short words: edges, triangles, quads, tetras, hexas.
std::string attributeOf(const CellKind& kind) { return std::string(kind.alias.empty() || kind.dimension != 3 ? kind.plural : kind.alias); }

class VTKExporter : public Observer {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void compile(const Simulation& simulation) override;
  void begin(const Simulation& simulation) override;
  void afterStep(const Simulation& simulation, const StepContext&) override;
  bool readsAllNodes(const StepContext& context) const override {
    return enable_ && every_ > 0 && context.index % every_ == 0;
  }
  void end(const Simulation& simulation) override;
  std::vector<std::string> files() const override;
  bool replacesFiles() const override { return true; }
  void serialize(Archive& archive) override;
  std::string describe() const override;

 private:
  struct CellOutput {
    std::string label, field;
    ForceField* source;
    vtkSmartPointer<vtkDoubleArray> values;
  };

  void chooseCells();
  void makeGrid();
  void makeArrays();
  void addCellField(const std::string& word);
  ForceField& forceFieldWith(const std::string& field) const;
  ForceField& forceFieldAt(const std::string& path) const;
  std::vector<double> fieldOfCells(const CellOutput& output) const;
  void fill();
  void write(const Simulation& simulation);
  const Mesh& mesh() const { return topology_ ? topology_->mesh() : no_mesh_; }

  FileName filename_;
  Link<State> mstate_{"mechanical state"};
  TopologyLink topology_link_;
  std::vector<Vec3> position_;
  std::vector<std::string> point_words_, cell_words_;
  int every_ = 1;
  bool at_begin_ = false, at_end_ = false, enable_ = true, xml_ = true, overwrite_ = false;
  PerCellList<bool> wanted_{.tetrahedra = true, .hexahedra = true, .prisms = true, .pyramids = true, .quadratic_tetrahedra = true};

  State* state_ = nullptr;
  const Topology* topology_ = nullptr;
  const System* system_ = nullptr;
  VtkSeries series_;
  vtkSmartPointer<vtkUnstructuredGrid> grid_;
  vtkSmartPointer<vtkDoubleArray> points_, time_;
  PointFields point_fields_;
  Mesh no_mesh_;  ///< of frames without one
  std::vector<CellOutput> cell_outputs_;
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
  forEachCellList(
      [&table](const CellKind& kind, bool& wanted) {
        table.add(attributeOf(kind), wanted).help(fmt::format("write {}", kind.plural));
      },
      wanted_);
  table.add("pointsDataFields", point_words_).help("fields of the nodes");
  table.add("cellsDataFields", cell_words_).help("fields of the cells");
  table.add("position", position_)
      .unit("m")
      .help("positions of the state, for SOFA's scenes; those are always written");
  topology_link_.declare(table, "mesh to export");
  table.addLink("mstate", mstate_).help("the state; default: that of the node or above");
}

void VTKExporter::init() {
  state_ = mstate_.target() ? mstate_.get() : find<State>(true);
  if (!state_) throw ComponentError("there is no state to export", "a MechanicalObject here or above, or mstate");
  topology_ = topology_link_.find(*this, *state_);
  if (!topology_ && !state_->hasFrames())
    throw ComponentError("there is no mesh to export", "a topology in the node or above, or topology");
  if (!position_.empty() && Index(position_.size()) != state_->nodes())
    throw ComponentError(fmt::format("position has {} values for {} nodes", position_.size(), state_->nodes()));
  if (enable_ && every_ == 0 && !at_begin_ && !at_end_)
    warn("nothing will be written", "exportEveryNumberOfSteps, exportAtBegin or exportAtEnd");
  series_.setUp(filename_.empty() ? name() : filename_.given, {xml_, overwrite_});
  chooseCells();
  makeGrid();
  point_fields_.start(*state_, *grid_->GetPointData());
  for (const std::string& word : point_words_) point_fields_.add(word, *this, *grid_->GetPointData());
  for (const std::string& word : cell_words_) addCellField(word);
}

void VTKExporter::chooseCells() {
  bool any_given = false;
  const auto look = [&](const CellKind& kind, bool) {
    any_given = any_given || data().find(attributeOf(kind))->isSet();
  };
  forEachCellList(look, wanted_);
  if (any_given) return;
  const int highest = std::max(1, highestDimension(mesh()));
  forEachCellList([&](const CellKind& kind, bool& wanted) { wanted = kind.dimension == highest; }, wanted_);
}

/// Cells of the highest dimension come first.
void VTKExporter::makeGrid() {
  const Mesh& mesh = this->mesh();
  grid_ = vtkSmartPointer<vtkUnstructuredGrid>::New();
  const auto add = [this](const CellKind& kind, const auto& cells) {
    for (const auto& cell : cells) {
      std::array<vtkIdType, most_cell_nodes> ids{};
      for (std::size_t k = 0; k < cell.size(); ++k) ids[k] = cell[kind.vtk.order[k]];
      grid_->InsertNextCell(kind.vtk.number, vtkIdType(cell.size()), ids.data());
    }
  };
  for (const int dimension : {3, 2, 1})
    forEachCellList(
        [&](const CellKind& kind, bool wanted, const auto& cells) {
          if (wanted && kind.dimension == dimension) add(kind, cells);
        },
        wanted_, mesh);
  for (vtkIdType frame = 0; !topology_ && frame < state_->nodes(); ++frame) grid_->InsertNextCell(VTK_VERTEX, 1, &frame);
  makeArrays();
}

void VTKExporter::makeArrays() {
  if (grid_->GetNumberOfCells() == 0) warn("no cell will be written: the mesh has none of the requested kinds");
  points_ = vtkSmartPointer<vtkDoubleArray>::New();
  points_->SetNumberOfComponents(3);
  points_->SetNumberOfTuples(state_->nodes());
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetData(points_);
  grid_->SetPoints(points);
  time_ = vtkSmartPointer<vtkDoubleArray>::New();
  time_->SetName("TimeValue");
  time_->SetNumberOfTuples(1);
  grid_->GetFieldData()->AddArray(time_);
}

void VTKExporter::addCellField(const std::string& word) {
  const FieldWord parts(word);
  ForceField& source = parts.owner.empty() ? forceFieldWith(parts.field) : forceFieldAt(parts.owner);
  source.ensureReady();
  const auto known = source.cellFields();
  if (std::find(known.begin(), known.end(), parts.field) == known.end())
    throw ComponentError(
        fmt::format("cellsDataFields: {} has no field '{}'", source.path(), parts.field),
        known.empty() ? "a force field with cell fields" : fmt::format("one of {}", fmt::join(known, ", ")),
        nearest(parts.field, known));
  const std::string label = parts.label.empty() ? parts.field : parts.label;
  auto values = vtkSmartPointer<vtkDoubleArray>::New();
  values->SetName(label.c_str());
  values->SetNumberOfComponents(int(source.cellFieldShape(parts.field).width));
  values->SetNumberOfTuples(grid_->GetNumberOfCells());
  cell_outputs_.push_back({label, parts.field, &source, values});
  grid_->GetCellData()->AddArray(cell_outputs_.back().values);
}

ForceField& VTKExporter::forceFieldAt(const std::string& path) const {
  Component& owner = componentAt(node(), path);
  auto* source = dynamic_cast<ForceField*>(&owner);
  if (!source) throw ComponentError(fmt::format("cellsDataFields: {} is not a force field", owner.path()));
  return *source;
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

/// Fields are evaluated once: how many values a force field gives shows there only.
void VTKExporter::compile(const Simulation& simulation) {
  system_ = nullptr;
  for (const auto& system : simulation.systems())
    for (const State* state : system->states())
      if (state == state_) system_ = system.get();
  if (cell_outputs_.empty() || files().empty()) return;
  if (!system_)
    throw ComponentError("cell fields need a state that an integrator moves",
                         "an integrator in the state's node or above");
  for (const CellOutput& output : cell_outputs_) {
    const auto& moved = system_->states();
    if (std::find(moved.begin(), moved.end(), &output.source->state()) == moved.end())
      throw ComponentError(fmt::format("cellsDataFields: {} acts on {}, which {} does not move", output.source->path(),
                                       output.source->state().path(), system_->integrator().path()),
                           fmt::format("a force field on {}", state_->path()));
    fieldOfCells(output);
  }
}

void VTKExporter::begin(const Simulation& simulation) {
  if (simulation.steps() == 0) last_step_ = -1;
  if (enable_) series_.start(simulation.steps() == 0);
  if (enable_ && at_begin_ && simulation.steps() == 0) write(simulation);
}

void VTKExporter::afterStep(const Simulation& simulation, const StepContext&) {
  if (enable_ && every_ > 0 && simulation.steps() % every_ == 0) write(simulation);
}

void VTKExporter::end(const Simulation& simulation) {
  if (enable_ && at_end_ && last_step_ != simulation.steps()) write(simulation);
}

std::vector<std::string> VTKExporter::files() const {
  const bool writes = enable_ && (every_ > 0 || at_begin_ || at_end_);
  return writes ? series_.files() : std::vector<std::string>{};
}

/// The files of the run so far: a series goes on with the next number.
void VTKExporter::serialize(Archive& archive) {
  archive.value("last_step", last_step_);
  series_.serialize(archive);
}

std::string VTKExporter::describe() const {
  if (!enable_) return "writes nothing (enable=\"false\")";
  return fmt::format("writes {} {}{}{}", series_.pattern(),
                     every_ == 0 ? "never" : fmt::format("every {} steps", every_), at_begin_ ? ", at the begin" : "",
                     at_end_ ? ", at the end" : "");
}

void VTKExporter::fill() {
  for (Index node = 0; node < state_->nodes(); ++node) {
    const Index row = node * state_->rows_per_node;  // of a frame the centre
    const Vec3 x = state_->isBound() ? Vec3(state_->x()[row]) : state_->position[std::size_t(row)];
    std::copy_n(x.data(), 3, points_->GetPointer(3 * vtkIdType(node)));
  }
  point_fields_.fill();
  for (CellOutput& output : cell_outputs_) {
    const std::vector<double> values = fieldOfCells(output);
    std::copy(values.begin(), values.end(), output.values->GetPointer(0));
    output.values->Modified();
  }
  points_->Modified();
}

/// The numbers of each written cell, NaN where the force field has none.
std::vector<double> VTKExporter::fieldOfCells(const CellOutput& output) const {
  std::vector<double> values;
  output.source->cellField(output.field, system_->x, values);
  const auto [of, width] = output.source->cellFieldShape(output.field);
  std::vector<double> out(width * std::size_t(grid_->GetNumberOfCells()), std::numeric_limits<double>::quiet_NaN());
  std::size_t cells_of_kind = 0;
  auto to = out.begin();
  const auto place = [&, kind_of_values = of, each = width](const CellKind& kind, bool wanted, const auto& cells) {
    const bool has_values = kind_of_values && kind.type == kind_of_values->type;
    if (has_values) cells_of_kind = cells.size();
    if (wanted && has_values && values.size() == each * cells.size()) std::copy(values.begin(), values.end(), to);
    if (wanted) to += std::ptrdiff_t(each * cells.size());
  };
  for (const int dimension : {3, 2, 1})  // as in makeGrid()
    forEachCellList(
        [&](const CellKind& kind, bool wanted, const auto& cells) {
          if (kind.dimension == dimension) place(kind, wanted, cells);
        },
        wanted_, mesh());
  if (values.size() != width * cells_of_kind)
    throw ComponentError(fmt::format("cellsDataFields: {} gives '{}' for {} {}, but the exported mesh has {}",
                                     output.source->path(), output.field, values.size() / width,
                                     of ? of->plural : "cells", cells_of_kind),
                         "the topology of the force field");
  return out;
}

void VTKExporter::write(const Simulation& simulation) {
  fill();
  time_->SetValue(0, simulation.time());
  time_->Modified();
  series_.write(*grid_, simulation.time());
  last_step_ = simulation.steps();
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(vtk_exporter) {
  factory.add<stroma::VTKExporter>("VTKExporter", "writes the moving mesh and its fields for ParaView");
}
