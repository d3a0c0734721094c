// SPDX-License-Identifier: LGPL-2.1-or-later
// Expect: what a result is to be, by a formula or a stored number. `stroma run` compares, and a result that is none of what was
// expected ends it with exit code 1 and the numbers.
//
// `of` names what is compared:
//   PATH.displacement, .position, .velocity    of the nodes of a state, at `nodes` or all; `axis` x, y, z, all three, or norm.
//                                              Of frames their centres; of Vec1, Vec2 and Vec6 all numbers, x to z are the first
//   PATH.orientation, .angularVelocity         of frames: the shortest rotation vector [rad], and w [rad/s], in fixed axes
//   PATH.volume                                of the cells of a state's mesh, or behind its closed surface [m^3]
//   PATH.NAME                                  any attribute of numbers of any component; `nodes` are then places in its list
//   PATH.stress, .vonMises, .J ...             fields of the cells of a force field: the numbers of each cell one after another,
//                                              so that number k of cell c is at place 6 c + k of a stress (xx yy zz xy yz zx);
//                                              `nodes` of one whose mesh has changed since the start are a failure, not other cells
//   kinetic_energy, elastic_energy, gravity_energy, total_energy    of the scene [J]
//   linear_momentum, angular_momentum          of all masses on points and frames, about the origin [kg m/s], [kg m^2/s]; `axis`
//   energy_drift                               |E - E_0| over the largest |E|, kinetic energy or |E_0| so far, E the total
//   linear_iterations, newton_iterations       of the step that takes most
//
// `is` is a formula of t, and for nodes of x, y and z, their place at rest: "-9.81/2*t^2", "0.1*x". What is compared may differ
// from it by tolerance times the largest value of the formula, and by `absolute`. `below` and `above` are formulas of
// bounds. when="end" compares after the last step, when="always" after each, `at` at the first step that reaches each of these times.
// A time that the run does not reach is a failure too: nothing was compared.
//
// The formulas are read by muParser, as those of FormulaForceField.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -10 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject name="dofs" position="0 1 0  1 1 0"/>
//   <UniformMass totalMass="2"/>
//   <Expect of="/dofs.displacement" axis="y" is="-5*t*(t+0.01)" at="0.02" tolerance="1e-9"/>
//   <Expect of="energy_drift" below="0.01" when="always"/>
// </Node>
#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "components/formulas/expected_values.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/load.h"
#include "framework/scene/text.h"
#include "framework/simulation/energies.h"
#include "framework/simulation/expectation.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace expect {

/// A formula of t, x, y and z.
class Formula {
 public:
  void read(const std::string& text, const char* attribute) {
    try {
      parser_.DefineVar("t", &t_);
      for (int c = 0; c < 3; ++c) parser_.DefineVar(std::string(1, "xyz"[c]), &place_[c]);
      parser_.DefineConst("pi", M_PI);
      parser_.SetExpr(text);
      parser_.Eval();
    } catch (const mu::Parser::exception_type& problem) {
      throw ComponentError(fmt::format("the formula '{}' of {} cannot be read: {}", text, attribute, problem.GetMsg()),
                           "a number, or a formula of t, x, y and z", "stroma doc FormulaForceField lists the functions");
    }
  }
  double at(double t, const Vec3& place) {
    t_ = t, place_ = place;
    return parser_.Eval();
  }

 private:
  mu::Parser parser_;
  double t_ = 0;
  Vec3 place_ = Vec3::Zero();
};

/// The numbers of an attribute, flat, and how many belong together.
struct Numbers {
  std::vector<double> flat;
  std::size_t width = 1;
};

template <class T>
void appendNumbers(const T& value, std::vector<double>& out) {
  if constexpr (std::is_arithmetic_v<T>) {
    out.push_back(double(value));
  } else if constexpr (std::is_same_v<T, Vec3>) {
    out.insert(out.end(), {value[0], value[1], value[2]});
  } else {
    for (const auto& item : value) appendNumbers(item, out);
  }
}

/// Empty for what holds no numbers.
std::optional<Numbers> numbersOf(const Data& data) {
  return std::visit(
      [](const auto& pointer) -> std::optional<Numbers> {
        using Pointer = std::decay_t<decltype(pointer)>;
        constexpr bool is_text = std::is_same_v<Pointer, std::string*> || std::is_same_v<Pointer, FileName*> ||
                                 std::is_same_v<Pointer, std::vector<std::string>*>;
        if constexpr (is_text || std::is_same_v<Pointer, ChoiceRef> || std::is_same_v<Pointer, LinkBase*> ||
                      std::is_same_v<Pointer, std::vector<bool>*>) {
          return {};
        } else {
          Numbers numbers;
          appendNumbers(*pointer, numbers.flat);
          using T = std::decay_t<decltype(*pointer)>;
          if constexpr (requires(T t) { t.resize(1); } && !std::is_same_v<T, Vec3>)
            if (!pointer->empty()) numbers.width = numbers.flat.size() / pointer->size();
          return numbers;
        }
      },
      data.pointer());
}

class Expect final : public Observer, public Expectation {
 public:
  void declare(DataTable& table) override;
  void compile(const Simulation& simulation) override;
  void begin(const Simulation& simulation) override;
  void stepMade(const StepReport& report) override {
    most_[0] = std::max(most_[0], double(report.linear_iterations));
    most_[1] = std::max(most_[1], double(report.newton_iterations));
  }
  void afterStep(const Simulation& simulation, const StepContext& context) override;
  void end(const Simulation& simulation) override;
  void reset() override { comparisons_ = 0, next_ = 0, scale_ = 0, first_count_ = 0, most_ = {}, failure_.clear(); }
  void serialize(Archive& archive) override {
    archive.value("start", start_);
    archive.value("scale", scale_);
    archive.value("linear", most_[0]);
    archive.value("newton", most_[1]);
    archive.value("next", next_);
    archive.value("comparisons", comparisons_);
    if (namesCells()) archive.value("first_count", first_count_);
  }
  std::string describe() const override {
    if (!at_.empty()) return fmt::format("compares {} at {} times", of_, at_.size());
    return fmt::format("compares {} {}", of_, always_ == When::end ? "at the end" : "after each step");
  }
  long comparisons() const override { return long(comparisons_); }
  std::string failure() const override { return failure_; }

 private:
  enum class When : int { end, always } always_ = When::end;
  enum class Axis : int { all, x, y, z, norm } axis_ = Axis::all;
  bool isWord(const char* word) const { return of_ == word; }
  bool isMomentum() const { return isWord("linear_momentum") || isWord("angular_momentum"); }
  bool namesCells() const { return field_ && !nodes_.empty(); }
  double countOfField(const Simulation& simulation) const;
  std::vector<Value> values(const Simulation& simulation) const;
  void findNumbers(const Simulation& simulation);
  std::vector<Value> listValues() const;
  double volume() const;
  double sceneValue(const Simulation& simulation) const;
  void note(const Simulation& simulation);
  void compare(const Simulation& simulation);
  void fail(const Simulation& simulation, const Value& value, const std::string& expected);

  std::string of_, is_, below_, above_;
  std::vector<int> nodes_;
  std::vector<double> at_;
  double tolerance_ = 1e-6, absolute_ = 0;
  Formula exact_, lower_, upper_;

  const State* state_ = nullptr;
  const Component* owner_ = nullptr;
  const ForceField* field_ = nullptr;  ///< of a field of cells
  const System* system_ = nullptr;     ///< that it acts in
  std::string name_;  ///< behind the dot
  double start_ = 0, scale_ = 0;
  std::array<double, 2> most_{};  ///< iterations, linear and of Newton's method
  double next_ = 0, comparisons_ = 0;
  double first_count_ = 0;  ///< numbers of a field of which cells are named, where the scene starts
  std::string failure_;
};

constexpr std::array<const char*, 9> scene_words = {
    "kinetic_energy", "elastic_energy", "gravity_energy",  "total_energy",    "energy_drift", "linear_iterations",
    "newton_iterations", "linear_momentum", "angular_momentum"};
constexpr std::array<const char*, 6> node_words = {"displacement", "position", "velocity", "volume", "orientation", "angularVelocity"};

void Expect::declare(DataTable& table) {
  table.add("of", of_).help("what is compared: PATH.NAME, or an energy or iterations of the scene").required();
  table.add("is", is_).help("a formula of t, x, y and z that it equals");
  table.add("below", below_).help("a formula that it stays below");
  table.add("above", above_).help("a formula that it stays above");
  table.add("nodes", nodes_).help("nodes, or places in a list, of cells too; all when not given").min(0);
  table.addChoice("axis", axis_, {"all", "x", "y", "z", "norm"}).help("of nodes and lists of vectors: what of them is compared");
  table.addChoice("when", always_, {"end", "always"}).help("after the last step, or after each");
  table.add("at", at_).help("times, ascending: at the first step that reaches each, instead").unit("s");
  table.add("tolerance", tolerance_).help("share of the largest value of `is` by which it may differ").unit("-").min(0);
  table.add("absolute", absolute_).help("by how much it may differ besides, in the unit of what is compared").min(0);
}

void Expect::compile(const Simulation& simulation) {
  if (is_.empty() && below_.empty() && above_.empty()) throw ComponentError("nothing is expected", "is, below or above");
  if (!is_.empty()) exact_.read(is_, "is");
  if (!below_.empty()) lower_.read(below_, "below");
  if (!above_.empty()) upper_.read(above_, "above");
  if (!std::is_sorted(at_.begin(), at_.end())) throw ComponentError("the times of `at` do not ascend", "ascending times");
  if (std::find(scene_words.begin(), scene_words.end(), of_) != scene_words.end()) {
    if (isMomentum()) checkMomentum(simulation.systems());
    return;
  }
  const auto dot = of_.rfind('.');
  const std::string path = of_.substr(of_.starts_with("@") ? 1 : 0, dot == std::string::npos ? dot : dot - of_.starts_with("@"));
  owner_ = dot == std::string::npos ? nullptr : findComponent(simulation.root(), path);
  if (!owner_) {
    std::vector<Component*> all;
    simulation.root().collect(all);
    std::vector<std::string> names(scene_words.begin(), scene_words.end());
    for (const Component* each : all) names.push_back(each->path());
    throw ComponentError(fmt::format("`of` names {}, which the scene does not have", inQuotes(of_)),
                         "PATH.NAME with the path of a component, or a word such as energy_drift", nearest(path, names));
  }
  name_ = of_.substr(dot + 1);
  const bool of_nodes = std::find(node_words.begin(), node_words.end(), name_) != node_words.end();
  state_ = of_nodes ? dynamic_cast<const State*>(owner_) : nullptr;
  if (!state_) findNumbers(simulation);
  if (field_ && axis_ != Axis::all)
    throw ComponentError(fmt::format("`axis` chooses of vectors, and {} is a field of cells", of_), "places of its numbers as `nodes`");
  if (state_ && name_ == "volume" && !topologyOf(*state_)) throw ComponentError(state_->path() + " has no mesh, so it has no volume");
  if (state_ && (name_ == "orientation" || name_ == "angularVelocity") && !state_->hasFrames())
    throw ComponentError(fmt::format("the nodes of {} have no orientation", state_->path()), "a state of template Rigid3");
  if (state_ && name_ != "volume")
    for (const int node : nodes_)
      if (node >= state_->nodes())
        throw ComponentError(fmt::format("there is no node {}", node), fmt::format("0 to {}", state_->nodes() - 1));
}

/// An attribute, or a field of cells.
void Expect::findNumbers(const Simulation& simulation) {
  if (const Data* data = owner_->data().find(name_); data && numbersOf(*data)) return;
  std::vector<std::string> names = owner_->data().names(), fields;
  if (const auto* field = dynamic_cast<const ForceField*>(owner_)) fields = field->cellFields();
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields())
      if (field == owner_ && std::find(fields.begin(), fields.end(), name_) != fields.end()) field_ = field, system_ = system.get();
  names.insert(names.end(), fields.begin(), fields.end());
  if (!field_)
    throw ComponentError(fmt::format("{} has no numbers called {}", owner_->path(), inQuotes(name_)),
                         "an attribute of numbers, or a field of cells", nearest(name_, names));
}

/// Another one than at the start tells that cells have gone or come.
double Expect::countOfField(const Simulation& simulation) const {
  simulation.complete();
  std::vector<double> numbers;
  field_->cellField(name_, system_->x, numbers);
  return double(numbers.size());
}

void Expect::begin(const Simulation& simulation) {
  if (simulation.steps() > 0) return;
  if (namesCells()) first_count_ = countOfField(simulation);
  start_ = energiesOf(simulation.systems()).total;
  scale_ = std::abs(start_);
  while (std::size_t(next_) < at_.size() && at_[std::size_t(next_)] <= simulation.time()) {
    ++next_;
    compare(simulation);
  }
}

/// What grows over the run.
void Expect::note(const Simulation& simulation) {
  if (!isWord("energy_drift")) return;
  for (const auto& system : simulation.systems()) {
    scale_ = std::max(scale_, system->kineticEnergy());
    scale_ = std::max(scale_, std::abs(system->kineticEnergy() + system->potentialEnergy(system->x)));
  }
}

void Expect::afterStep(const Simulation& simulation, const StepContext& context) {
  note(simulation);
  if (always_ == When::always && at_.empty()) compare(simulation);
  const double close = 1e-6 * context.dt;
  while (std::size_t(next_) < at_.size() && context.t_end > at_[std::size_t(next_)] - close) {
    ++next_;
    compare(simulation);
  }
}

void Expect::end(const Simulation& simulation) {
  if (at_.empty() && always_ == When::end) compare(simulation);
  if (std::size_t(next_) < at_.size() && failure_.empty())
    failure_ = fmt::format("{} was not compared at t = {:g} s: the run ended at {:g} s", of_, at_[std::size_t(next_)], simulation.time());
}

std::vector<Value> Expect::values(const Simulation& simulation) const {
  const Chosen chosen{of_, int(axis_), nodes_};
  if (isMomentum()) {
    simulation.complete();
    return momentumOf(simulation.systems(), isWord("angular_momentum"), chosen);
  }
  if (!owner_) return {{sceneValue(simulation), of_}};
  if (field_) simulation.complete();
  if (!state_) return listValues();
  return name_ == "volume" ? std::vector<Value>{{volume(), of_}} : nodeValues(*state_, name_, chosen);
}

double Expect::sceneValue(const Simulation& simulation) const {
  if (isWord("linear_iterations")) return most_[0];
  if (isWord("newton_iterations")) return most_[1];
  const auto [kinetic, elastic, gravity, total] = energiesOf(simulation.systems());
  if (isWord("kinetic_energy")) return kinetic;
  if (isWord("elastic_energy")) return elastic;
  if (isWord("gravity_energy")) return gravity;
  if (isWord("total_energy")) return total;
  return scale_ > 0 ? std::abs(total - start_) / scale_ : 0;
}

std::vector<Value> Expect::listValues() const {
  Numbers numbers;
  if (field_) {
    field_->cellField(name_, system_->x, numbers.flat);
  } else {
    numbers = *numbersOf(*owner_->data().find(name_));
  }
  std::vector<Value> all;
  const std::size_t count = numbers.flat.size() / numbers.width;
  const auto add = [&](std::size_t i) {
    if (i >= count) return all.push_back({std::nan(""), fmt::format("{}[{}], of a list of {},", of_, i, count)});
    const double* at = numbers.flat.data() + i * numbers.width;
    const std::string name = count > 1 ? fmt::format("{}[{}]", of_, i) : of_;
    if (numbers.width == 3 && axis_ != Axis::all) return appendVector({at[0], at[1], at[2]}, int(axis_), name, Vec3::Zero(), all);
    for (std::size_t c = 0; c < numbers.width; ++c) all.push_back({at[c], name});
  };
  for (const int i : nodes_) add(std::size_t(i));
  for (std::size_t i = 0; nodes_.empty() && i < count; ++i) add(i);
  return all;
}

double Expect::volume() const {
  Mesh mesh = topologyOf(*state_)->mesh();
  for (std::size_t i = 0; i < mesh.position.size() && Index(i) < state_->nodes(); ++i)
    mesh.position[i] = state_->x()[Index(i) * state_->rows_per_node];
  if (highestDimension(mesh) == 3) return mesh.report().volume;
  double sum = 0;
  const auto add = [&](Index a, Index b, Index c) { sum += mesh.position[a].dot(mesh.position[b].cross(mesh.position[c])) / 6; };
  for (const Triangle& t : mesh.triangles) add(t[0], t[1], t[2]);
  for (const Quad& q : mesh.quads) {
    add(q[0], q[1], q[2]);
    add(q[0], q[2], q[3]);
  }
  return sum;
}

void Expect::fail(const Simulation& simulation, const Value& value, const std::string& expected) {
  if (!failure_.empty()) return;
  failure_ = fmt::format("{} is {:.9g} at t = {:g} s, expected {}", value.name, value.number, simulation.time(), expected);
}

void Expect::compare(const Simulation& simulation) {
  const std::vector<Value> all = values(simulation);
  ++comparisons_;
  const double t = simulation.time();
  if (const double count = namesCells() ? countOfField(simulation) : 0; count != first_count_ && failure_.empty())
    failure_ = fmt::format("{} had {:.0f} numbers where the scene starts and has {:.0f} at t = {:g} s: `nodes` would name other cells", of_,
                           first_count_, count, t);
  if (all.empty() && failure_.empty()) failure_ = fmt::format("{} holds no numbers at t = {:g} s", of_, t);
  double size = 0;
  for (const Value& value : all)
    if (!is_.empty()) size = std::max(size, std::abs(exact_.at(t, value.place)));
  const double allowed = tolerance_ * size + absolute_;
  for (const Value& value : all) {
    if (!is_.empty()) {
      const double wanted = exact_.at(t, value.place), off = std::abs(value.number - wanted);
      if (!(off <= allowed)) fail(simulation, value, fmt::format("{:.9g} (off by {:.3g}, allowed {:.3g})", wanted, off, allowed));
    }
    const double most = below_.empty() ? 0 : lower_.at(t, value.place), least = above_.empty() ? 0 : upper_.at(t, value.place);
    if (!below_.empty() && !(value.number < most)) fail(simulation, value, fmt::format("below {:.9g}", most));
    if (!above_.empty() && !(value.number > least)) fail(simulation, value, fmt::format("above {:.9g}", least));
  }
}

}  // namespace expect
}  // namespace stroma

STROMA_COMPONENT(expect) {
  factory.add<stroma::expect::Expect>("Expect", "what a result is to be: compared, and a difference ends with exit code 1");
}
