// SPDX-License-Identifier: LGPL-2.1-or-later
// Monitor: positions, velocities and forces of selected nodes over time, and outputs of other components, in columns for
// gnuplot.
//
// One text file for each quantity asked for: <fileName>_x.txt (positions), <fileName>_v.txt (velocities),
// <fileName>_f.txt (net force of all force fields and of gravity at that instant, which takes one evaluation more per
// step; at a node that a constraint holds the reaction of the support has the opposite sign). Their head names the units
// of the scene, where they are known (docs/units.md). A line starts with the time; then follow the three components of
// each node in the order of `indices`. The first line is the start, then one per step. Numbers have the fewest digits
// that read back to the same bits. To plot the height of the first node: `plot "tip_x.txt" using 1:3 with lines`.
//
// `attributes` are words `component.attribute` or `label=component.attribute`, of a component of this node or above, or at a
// path: contact.wrenches, /body/contact.pressures. Each has a file, <fileName>_<attribute>.txt or <fileName>_<label>.txt. From
// lists with a value for each node it writes those of the selected nodes, or of all if no `indices` are given; from others all
// numbers. The first line is written when there are values. Attributes of states are not accepted, because they are initial
// values. Cell fields are named in the same way, as tissue.stress (Cauchy stress xx yy zz xy yz zx) or tissue.vonMises: for
// `cells`, one after another, or for all.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject name="dofs" position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="2"/>
//   <Monitor name="tip" indices="1" ExportPositions="true" ExportVelocities="true"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "components/output/table_file.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"
#include "framework/scene/load.h"
#include "framework/scene/node.h"
#include "framework/scene/written_units.h"
#include "framework/simulation/simulation.h"
#include "framework/simulation/state_file.h"

namespace stroma {
namespace {

class Monitor final : public Observer {
 public:
  void declare(DataTable& table) override {
    table.addLink("mstate", mstate_).help("state to watch; the one of this node by default");
    table.add("indices", nodes_).help("nodes to watch; with attributes alone, those of which lists for all nodes are written; empty: all");
    table.add("ExportPositions", export_x_).help("write <fileName>_x.txt");
    table.add("ExportVelocities", export_v_).help("write <fileName>_v.txt");
    table.add("ExportForces", export_f_).help("write <fileName>_f.txt");
    table.add("attributes", words_).help("what other components compute, as contact.wrenches: write <fileName>_wrenches.txt");
    table.add("cells", cells_).help("cells of whose fields, as tissue.stress among attributes, numbers are written; empty: all").min(0);
    table.add("fileName", file_name_).help("prefix of the file names; the component's name by default");
    for (const char* drawing :
         {"showPositions", "showVelocities", "showForces", "showTrajectories", "PositionsColor", "VelocitiesColor",
          "ForcesColor", "TrajectoriesColor", "sizeFactor", "showMinThreshold", "TrajectoriesPrecision"})
      table.addVisualOnly(drawing);
  }

  void init() override {
    state_ = mstate_.get() ? mstate_.get() : find<State>();
    if (!state_) throw ComponentError("no state to watch", "a MechanicalObject in this node, or mstate=\"@path\"");
    const bool writes_state = export_x_ || export_v_ || export_f_;
    if (writes_state || data().find("indices")->isSet()) checkedNodesInOrder(nodes_, *state_, "indices");
    if (export_f_) state_->requestForce();
    watched_.clear();
    for (const std::string& word : words_) watch(word);
    if (!writes_state && words_.empty())
      warn("writes nothing", "set ExportPositions, ExportVelocities or ExportForces to true, or attributes");
  }

  void compile(const Simulation& simulation) override {
    for (const auto& each : watched_)
      for (const auto& system : simulation.systems())
        if (const auto all = system->forceFields(); each->field && std::find(all.begin(), all.end(), each->field) != all.end())
          each->system = system.get();
    for (const auto& each : watched_)
      if (each->field && !cells_.empty()) numbersOfCells(*each);  // refuses what is no cell
    if (!state_->isBound())
      throw ComponentError(fmt::format("no integrator moves the state {}", state_->path()),
                           "an integrator in the state's node or above");
  }
  void begin(const Simulation& simulation) override {
    goes_on_ = simulation.steps() > 0;
    bool is_new = false;
    const auto unit = [&](const char* si_unit) { return unitInBrackets(simulation.scene(), si_unit); };
    const auto of_places = [&](const char* si_unit) {  // numbers may be angles or lengths
      return state_->kindOf(0) == RowKind::value ? std::string() : unit(si_unit);
    };
    time_unit_ = unit("s");
    if (export_x_) is_new = open(x_file_, "x", "positions" + of_places("m"), "the quaternion x y z w") || is_new;
    if (export_v_)
      is_new = open(v_file_, "v", "velocities" + of_places("m/s"), "the angular velocity about x y z" + unit("rad/s")) || is_new;
    if (export_f_) is_new = open(f_file_, "f", "forces" + of_places("N"), "the torque about x y z" + unit("N m")) || is_new;
    for (const auto& each : watched_) {
      const std::string si_unit = each->data ? each->data->unitText() : "";
      const std::vector<int>& chosen = each->field ? cells_ : nodes_;
      const std::string head = fmt::format(
          "# {}{} of {}\n# column 1: time{}; then its numbers, of lists for all {} those of {}{}\n", each->name,
          si_unit.empty() || si_unit == "-" ? "" : unit(si_unit.c_str()), each->owner->path(), time_unit_,
          each->field ? "cells" : "nodes", chosen.empty() ? "all" : each->field ? "cells " : "nodes ", fmt::join(chosen, " "));
      is_new = each->file.open(fileOf(each->label.c_str()), goes_on_, head) || is_new;
    }
    if (!is_new) return;
    if (export_f_)
      for (const auto& system : simulation.systems()) system->computeForce(system->x, system->v, system->f);
    if (readsCells()) simulation.complete();
    write(simulation.time());
  }

  void afterStep(const Simulation& simulation, const StepContext& context) override {
    if (readsCells()) simulation.complete();
    write(context.t_end);
  }
  void end(const Simulation&) override {
    for (TableFile* file : {&x_file_, &v_file_, &f_file_}) file->close();
    for (const auto& each : watched_) each->file.close();
  }
  void serialize(Archive& archive) override {
    x_file_.serialize(archive, "end_of_x");
    v_file_.serialize(archive, "end_of_v");
    f_file_.serialize(archive, "end_of_f");
    for (const auto& each : watched_) each->file.serialize(archive, "end_of_" + each->label);
  }
  std::vector<std::string> files() const override {
    std::vector<std::string> files;
    if (export_x_) files.push_back(fileOf("x"));
    if (export_v_) files.push_back(fileOf("v"));
    if (export_f_) files.push_back(fileOf("f"));
    for (const auto& each : watched_) files.push_back(fileOf(each->label.c_str()));
    return files;
  }
  bool readsAllNodes(const StepContext&) const override { return readsCells(); }
  void addWatchedNodes(const State& state, std::vector<Index>& nodes) const override {
    if (&state == state_)
      for (const int node : nodes_) nodes.push_back(node * state.rows_per_node);
  }

  std::string describe() const override {
    std::string what;
    if (export_x_ || export_v_ || export_f_)
      what = fmt::format("{}{}{}of {} nodes of {}", export_x_ ? "positions " : "", export_v_ ? "velocities " : "",
                         export_f_ ? "forces " : "", nodes_.size(), state_->path());
    return fmt::format("writes {}{}{} to {}_*.txt every step", what, what.empty() || words_.empty() ? "" : " and ",
                       fmt::join(words_, " "), stem());
  }

 private:
  /// An attribute of another component, or a field of the cells of a force field.
  struct Watched {
    std::string label, name;
    const Component* owner;
    const Data* data;
    const ForceField* field;
    TableFile file{};
    const System* system = nullptr;
  };
  bool readsCells() const {
    return std::any_of(watched_.begin(), watched_.end(), [](const auto& each) { return each->field; });
  }
  void watch(const std::string& word);
  Component* componentAt(const std::string& path) const;
  void writeLine(Watched& watched, double t);
  std::vector<double> numbersOfCells(const Watched& watched) const;

  std::string stem() const { return file_name_.empty() ? name() : file_name_.found; }
  std::string fileOf(const char* ending) const { return fmt::format("{}_{}.txt", stem(), ending); }

  /// `turning`: what a frame has besides x y z.
  bool open(TableFile& file, const char* ending, const std::string& quantity, const std::string& turning) {
    std::string head =
        fmt::format("# {} of {}\n# column 1: time{}; then {} of nodes", quantity, state_->path(), time_unit_,
                    state_->hasPointsOnly() ? "x y z"
                    : !state_->hasFrames()  ? "the numbers"
                                            : "x y z and " + turning);
    for (const int node : nodes_) head += fmt::format(" {}", node);
    return file.open(fileOf(ending), goes_on_, head + "\n");
  }

  void write(double t) {
    if (export_x_) writeLine(x_file_, t, state_->x(), true);
    if (export_v_) writeLine(v_file_, t, state_->v());
    if (export_f_) writeLine(f_file_, t, state_->f());
    for (const auto& each : watched_) writeLine(*each, t);
  }

  void writeLine(TableFile& file, double t, ConstRows rows, bool positions = false) {
    line_.clear();
    appendNumber(line_, t);
    for (const int node : nodes_)
      for (Index k = 0; k < state_->rows_per_node; ++k) {
        const Index row = node * state_->rows_per_node + k;
        const RowKind kind = state_->kindOf(row);
        const int numbers = kind == RowKind::value ? 1 : kind == RowKind::turn && positions ? 4 : 3;
        for (int c = 0; c < numbers; ++c) appendNumber(line_ += ' ', rows.data[row * row_doubles + c]);
      }
    file.write(line_ += '\n');
  }

  Link<State> mstate_{"mechanical state"};
  std::vector<int> nodes_, cells_;
  bool export_x_ = false, export_v_ = false, export_f_ = false;
  std::vector<std::string> words_;
  FileName file_name_;

  State* state_ = nullptr;
  std::vector<std::unique_ptr<Watched>> watched_;
  std::string time_unit_;  ///< " [s]"
  TableFile x_file_, v_file_, f_file_;
  bool goes_on_ = false;  ///< from a checkpoint
  std::string line_;
};

/// By a path from the root, or by its name in this node or the nearest above that has it; null: there is none.
Component* Monitor::componentAt(const std::string& path) const {
  if (path.find('/') != std::string::npos) return findComponent(node().root(), path);
  for (Node* at = &node(); at; at = at->parent())
    if (Component* found = at->findByName(path)) return found;
  return nullptr;
}

bool holdsNumbers(const DataPointer& at) {
  return std::holds_alternative<std::vector<Vec3>*>(at) || std::holds_alternative<std::vector<double>*>(at) ||
         std::holds_alternative<std::vector<int>*>(at) || std::holds_alternative<double*>(at) || std::holds_alternative<int*>(at) ||
         std::holds_alternative<Vec3*>(at);
}

void Monitor::watch(const std::string& word) {
  const std::size_t equals = word.find('='), begin = equals == std::string::npos ? 0 : equals + 1, dot = word.rfind('.');
  if (dot == std::string::npos || dot < begin)
    throw ComponentError(fmt::format("attributes: '{}' names no attribute", word), "component.attribute, as contact.wrenches");
  std::string path = word.substr(begin, dot - begin);
  const std::string attribute = word.substr(dot + 1);
  if (path.starts_with('@')) path.erase(0, 1);
  const Component* owner = componentAt(path);
  if (!owner)
    throw ComponentError(fmt::format("attributes: there is no component '{}'", path), "a name in this node or above, or a path");
  if (dynamic_cast<const State*>(owner))
    throw ComponentError(fmt::format("attributes: {} is a state, whose attributes are initial values", owner->path()),
                         "ExportPositions, ExportVelocities or ExportForces, of another state with mstate=\"@path\"");
  const Data* data = owner->data().find(attribute);
  const auto* field = data ? nullptr : dynamic_cast<const ForceField*>(owner);
  const std::vector<std::string> fields = field ? field->cellFields() : std::vector<std::string>();
  if (!data && std::find(fields.begin(), fields.end(), attribute) == fields.end()) {
    std::vector<std::string> names = owner->data().names();
    names.insert(names.end(), fields.begin(), fields.end());
    throw ComponentError(fmt::format("attributes: {} has no '{}'", owner->path(), attribute),
                         "an attribute that it computes, or a field of its cells", nearest(attribute, names));
  }
  if (data && !holdsNumbers(data->pointer()))
    throw ComponentError(fmt::format("attributes: {} of {} is a {}", attribute, owner->path(), data->typeText()),
                         "numbers or vectors");
  const std::string label = begin > 0 ? word.substr(0, equals) : attribute;
  if (label == "x" || label == "v" || label == "f" ||
      std::any_of(watched_.begin(), watched_.end(), [&](const auto& other) { return other->label == label; }))
    throw ComponentError(fmt::format("attributes: two files would be {}", fileOf(label.c_str())), "label=component.attribute");
  watched_.push_back(std::make_unique<Watched>(Watched{label, attribute, owner, data, field}));
}

/// Of the chosen cells, one after another.
std::vector<double> Monitor::numbersOfCells(const Watched& watched) const {
  std::vector<double> all, chosen;
  if (!watched.system) return {};
  watched.field->cellField(watched.name, watched.system->x, all);
  if (cells_.empty()) return all;
  const std::size_t width = watched.field->cellFieldShape(watched.name).width;
  for (const int cell : cells_) {
    const std::size_t first = std::size_t(cell) * width;
    if (first + width > all.size())
      throw ComponentError(fmt::format("cells: {} has no cell {}", watched.owner->path(), cell),
                           fmt::format("0 to {}", all.size() / width - 1));
    chosen.insert(chosen.end(), all.begin() + std::ptrdiff_t(first), all.begin() + std::ptrdiff_t(first + width));
  }
  return chosen;
}

void Monitor::writeLine(Watched& watched, double t) {
  line_.clear();
  const auto add = [this](const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, Vec3>)
      for (int k = 0; k < 3; ++k) appendNumber(line_ += ' ', value[k]);
    else
      appendNumber(line_ += ' ', double(value));
  };
  const auto addList = [&](const auto* list) {
    if (nodes_.empty() || Index(list->size()) != state_->nodes()) return std::for_each(list->begin(), list->end(), add), void();
    for (const int node : nodes_) add((*list)[std::size_t(node)]);
  };
  if (watched.field) {
    for (const double number : numbersOfCells(watched)) add(number);
  } else {
    const DataPointer& at = watched.data->pointer();
    if (const auto* number = std::get_if<double*>(&at)) add(**number);
    if (const auto* number = std::get_if<int*>(&at)) add(**number);
    if (const auto* point = std::get_if<Vec3*>(&at)) add(**point);
    if (const auto* list = std::get_if<std::vector<Vec3>*>(&at)) addList(*list);
    if (const auto* list = std::get_if<std::vector<double>*>(&at)) addList(*list);
    if (const auto* list = std::get_if<std::vector<int>*>(&at)) addList(*list);
  }
  if (line_.empty()) return;
  std::string whole;
  appendNumber(whole, t);
  watched.file.write(whole + line_ + '\n');
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(monitor) {
  factory.add<stroma::Monitor>("Monitor", "writes positions, velocities and forces of chosen nodes in columns");
}
