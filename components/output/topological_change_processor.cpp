// SPDX-License-Identifier: LGPL-2.1-or-later
// TopologicalChangeProcessor: planned changes of a mesh, by a file or by lists. Cells and points are removed or added between
// two steps; positions, velocities and histories of cells are kept, and everything that depends on the mesh is updated.
//
// The file has a line "T= TIME" before the changes of an instant, made in the first step that starts at TIME - shift or later:
//
//   T= 0.5
//   REMOVE= 2                 two cells of the mesh's own kind, by their numbers at that moment
//   3 17
//   ADD= Tetrahedra 1         also Edges, Triangles, Quads, Hexahedra: nodes of each
//   0 4 5 9
//   ADD= PointInTriangle 1    the triangle, and two of the three shares of its corners, for each new point
//   2 0.3 0.3
//
// With useDataInputs the lists below are removed in the first step that starts after timeToRemove, and again every `interval`.
// The last item of a list takes the number of a removed one, the largest number first. Faces and edges of removed cells, and
// points that lose their last cell, are removed with them.
//
// Source: names, attributes, the file and the numbering are SOFA's. Of several times within one step SOFA makes the changes of
// the last only; here all are made. Cuts along a path ("INCISE=") end the run.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <TetrahedronSetTopologyContainer position="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1" tetrahedra="0 1 2 3  1 4 2 3"/>
//   <MechanicalObject/>
//   <MeshMatrixMass massDensity="1000"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
//   <TetrahedronFEMForceField youngModulus="100000" poissonRatio="0.3"/>
//   <TopologicalChangeProcessor useDataInputs="true" timeToRemove="0.02" tetrahedraToRemove="1"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

#include "components/output/mesh_change_plan.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "framework/scene/text.h"

namespace stroma {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double slack = 1e-6;  // of a step

/// The changes of an instant, as the file has them.
struct Instant {
  struct Command {
    std::string word;                ///< REMOVE=, ADD= or INCISE=
    const CellKind* kind = nullptr;  ///< of what comes; null: points in triangles
    std::size_t count = 0;
    std::vector<double> numbers;
  };
  double time = 0;
  std::vector<Command> commands;
};

class ChangeFile {
 public:
  explicit ChangeFile(const FileName& name) : name_(name.given), stream_(name.found) {
    if (name_.ends_with(".gz")) throw ComponentError(fmt::format("the file {} is compressed", name_), "the text in it");
    if (!stream_) throw ComponentError(fmt::format("the file {} cannot be opened", name_));
  }

  std::vector<Instant> read() {
    std::vector<Instant> instants;
    std::string word;
    for (std::string line; next(line);) {
      std::istringstream words(line);
      words >> word;
      if (word == "T=") {
        std::string time;
        words >> time;
        instants.push_back({timeOf(time), {}});
      } else if (instants.empty()) {
        fail(inQuotes(trimmed(line)) + " stands before any time", "T= TIME");
      } else {
        instants.back().commands.push_back(command(word, words));
      }
    }
    std::stable_sort(instants.begin(), instants.end(),
                     [](const Instant& a, const Instant& b) { return a.time < b.time; });
    return instants;
  }

 private:
  /// The next line with something on it.
  bool next(std::string& line) {
    while (std::getline(stream_, line)) {
      ++number_;
      if (const std::string_view text = trimmed(line); !text.empty() && text.front() != '#') return true;
    }
    return false;
  }
  [[noreturn]] void fail(const std::string& what, const std::string& expected) const {
    throw ComponentError(fmt::format("{}:{}: {}", name_, number_, what), expected);
  }

  double timeOf(const std::string& word) const {
    char* end = nullptr;
    const double time = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0' || !std::isfinite(time)) fail(inQuotes(word) + " is no time", "T= TIME");
    return time;
  }

  Instant::Command command(const std::string& word, std::istringstream& words) {
    Instant::Command command{word, nullptr, 0, {}};
    std::string of;
    if (word != "REMOVE=" && word != "ADD=" && word != "INCISE=")
      fail(inQuotes(word) + " is no change", "T=, REMOVE=, ADD= or INCISE=");
    if (word == "ADD=") words >> of;
    long count = -1;
    if (!(words >> count) || count < 0)
      fail("how many is missing", word + (word == "ADD=" ? " KIND NUMBER" : " NUMBER"));
    command.count = std::size_t(count);
    std::size_t each = 1;
    if (word == "ADD=") {
      command.kind = kindOf(of);
      each = command.kind ? std::size_t(command.kind->nodes) : 3;
    }
    std::string line;
    if (!next(line)) fail("a line with numbers follows", "");
    std::istringstream numbers(line);
    for (double number; numbers >> number;) command.numbers.push_back(number);
    if (word != "INCISE=" && command.numbers.size() != each * command.count)
      fail(fmt::format("there are {} numbers", command.numbers.size()),
           fmt::format("{} for each of {}", each, command.count));
    return command;
  }

  const CellKind* kindOf(const std::string& word) const {
    if (word == "PointInTriangle" || word == "PointsInTriangle") return nullptr;
    for (const CellKind* kind : {&cell_kinds::edge, &cell_kinds::triangle, &cell_kinds::quad, &cell_kinds::tetrahedron,
                                 &cell_kinds::hexahedron}) {
      std::string plural(kind->plural);
      plural[0] = char(std::toupper(plural[0]));
      if (word == kind->word || word == plural) return kind;
    }
    fail(inQuotes(word) + " cannot come", "Edges, Triangles, Quads, Tetrahedra, Hexahedra or PointInTriangle");
  }

  std::string name_;
  std::ifstream stream_;
  int number_ = 0;  ///< of the line
};

class TopologicalChangeProcessor final : public MeshChangePlan {
 public:
  void declare(DataTable& table) override {
    MeshChangePlan::declare(table);
    table.add("filename", file_name_).help("file of the changes").input();
    table.add("interval", interval_).unit("s").min(0).help("time between removals of the lists; 0: once");
    table.add("shift", shift_).unit("s").help("time of the file less time of the scene");
    table.add("loop", loops_).help("after its last time the file begins again, that much later");
    table.add("useDataInputs", by_lists_).help("the lists below instead of the file");
    table.add("timeToRemove", time_).unit("s").help("when what they name is to be removed");
    table.add("pointsToRemove", points_).help("points to be removed");
    table.add("edgesToRemove", edges_).help("edges to be removed");
    table.add("trianglesToRemove", triangles_).help("triangles to be removed");
    table.add("quadsToRemove", quads_).help("quads to be removed");
    table.add("tetrahedraToRemove", tetrahedra_).help("tetrahedra to be removed");
    table.add("hexahedraToRemove", hexahedra_).help("hexahedra to be removed");
    for (const char* name : {"saveIndicesAtInit", "epsilonSnapPath", "epsilonSnapBorder", "draw", "listChanges"})
      table.addVisualOnly(name);
  }

  void init() override {
    instants_.clear();
    if (!by_lists_ && !file_name_.given.empty()) instants_ = ChangeFile(file_name_).read();
    std::erase_if(instants_, [](const Instant& instant) { return instant.commands.empty(); });
    const bool names_some =
        std::any_of(std::begin(lists_), std::end(lists_), [](const List& list) { return !list.numbers->empty(); });
    first_ = by_lists_ && names_some ? time_ : never;
    if (first_ == never && instants_.empty()) return reset();
    MeshChangePlan::init();
    if (loops_ && !instants_.empty() && !(instants_.back().time > 0))
      throw ComponentError("the file ends at a time that is not later than 0, and cannot begin again",
                           "loop=\"false\"");
    for (std::size_t i = 1; i < instants_.size(); ++i)
      if (instants_[i].time - instants_[i - 1].time < node().root().dt() * (1 - slack)) {
        warn(fmt::format(
            "the changes at {:g} s and {:g} s may fall into one step: both are made, where SOFA makes the last only",
            instants_[i - 1].time, instants_[i].time));
        break;
      }
    reset();
  }

  void reset() override { made_ = 0, next_ = first_; }
  void serialize(Archive& archive) override {
    archive.value("made", made_);
    archive.value("next", next_);
  }

  std::string describe() const override {
    const double first = by_lists_ ? first_ : instants_.empty() ? never : timeOf(0);
    return std::isfinite(first) ? fmt::format("changes {} from t = {:g} s on", topology().path(), first)
                                : "waits for nothing";
  }

  std::vector<MeshChange> changesAt(double t, double dt) override {
    std::vector<MeshChange> changes;
    if (by_lists_ && isListDue(t, dt)) {
      for (const List& list : lists_)
        if (!list.numbers->empty()) changes.push_back({&topology(), list.kind, *list.numbers, {}, {}, keeps_points_});
    }
    for (std::size_t k = made_; isFileDue(k, t, dt); ++k)
      for (const Instant::Command& command : instants_[k % instants_.size()].commands)
        changes.push_back(changeOf(command));
    return changes;
  }

  double plannedAt(double) const override { return by_lists_ ? next_ : timeOf(made_); }
  void changesMade(double t, double dt) override {
    while (isFileDue(made_, t, dt)) ++made_;
    if (by_lists_ && isListDue(t, dt)) next_ = interval_ > 0 ? next_ + interval_ : never;
  }

 private:
  struct List {
    const CellKind* kind;
    const std::vector<int>* numbers;
  };

  bool isListDue(double t, double dt) const { return t > next_ + slack * dt; }
  bool isFileDue(std::size_t k, double t, double dt) const {
    return !instants_.empty() && (loops_ || k < instants_.size()) && t >= timeOf(k) - slack * dt;
  }
  /// Of instant k, counted on where the file begins again.
  double timeOf(std::size_t k) const {
    const std::size_t count = instants_.size();
    return instants_[k % count].time + double(k / count) * instants_.back().time - shift_;
  }

  MeshChange changeOf(const Instant::Command& command) const {
    if (command.word == "INCISE=")
      throw ComponentError(path() + " cuts a mesh along a path, which is not made here", "REMOVE= and ADD=");
    MeshChange change;
    change.topology = &topology(), change.keeps_points = keeps_points_;
    if (command.word == "REMOVE=") {
      change.kind = &mainKind();
      change.removed.assign(command.numbers.begin(), command.numbers.end());
    } else if (command.kind) {
      change.kind = command.kind;
      const auto nodes = std::ptrdiff_t(command.kind->nodes);
      for (auto at = command.numbers.begin(); at != command.numbers.end(); at += nodes)
        change.added.emplace_back(at, at + nodes);
    } else {
      const std::vector<Triangle>& triangles = topology().mesh().triangles;
      for (std::size_t i = 0; i < command.numbers.size(); i += 3) {
        const double number = command.numbers[i], a = command.numbers[i + 1], b = command.numbers[i + 2];
        if (!(number >= 0 && number < double(triangles.size())))
          throw ComponentError(fmt::format("there is no triangle {}: there are {}", number, triangles.size()));
        const Triangle& corners = triangles[std::size_t(number)];
        change.points.push_back({{Index(corners[0]), a}, {Index(corners[1]), b}, {Index(corners[2]), 1 - a - b}});
      }
    }
    return change;
  }

  FileName file_name_;
  bool loops_ = false, by_lists_ = false;
  double interval_ = 0, shift_ = 0, time_ = 0;
  std::vector<int> points_, edges_, triangles_, quads_, tetrahedra_, hexahedra_;
  const List lists_[6] = {{&cell_kinds::hexahedron, &hexahedra_}, {&cell_kinds::tetrahedron, &tetrahedra_},
                          {&cell_kinds::quad, &quads_},           {&cell_kinds::triangle, &triangles_},
                          {&cell_kinds::edge, &edges_},           {&cell_kinds::point, &points_}};
  std::vector<Instant> instants_;  ///< of the file, ascending
  double first_ = never;           ///< when the lists are due first [s]
  std::size_t made_ = 0;           ///< instants of the file
  double next_ = never;            ///< when the lists are due [s]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(topological_change_processor) {
  factory.add<stroma::TopologicalChangeProcessor>("TopologicalChangeProcessor",
                                                  "removes and adds cells and points of a mesh at times");
}
