// SPDX-License-Identifier: LGPL-2.1-or-later
// InterventionalRadiologyController: catheters and guide wires that are pushed through one opening and turned there, one in the other.
//
// `instruments` names the rods, the outermost first. At the start of each step the tip of rod i is xtip[i] [m] behind the opening,
// measured along it, and the rod is turned by rotationInstrument[i] about its axis where it comes in. The tip of controlledInstrument
// goes on by speed dt in each step. Tips go no further than their rods are long. A program may set these attributes in a run.
// motionFilename is a text file instead of `speed` (tip_motion.h).
//
// The last nodes of the mesh are the rods that are out, the last node the tip that is furthest. Nodes lie at key points of the rods and
// where densityOfBeams has them, so that beams come and go as rods move; nodes that carry no beam wait at startingPos. Where a rod
// is alone its nodes move on with it, and the beam at the opening becomes longer: that is what pushes. Where rods lie in one
// another nodes stay in space and the rods slide through them; each has beams of its own between the same nodes. When nodes are
// others than before, they get places and velocities on the curve between those that were there. That is done once, where a step
// begins, also by integrators that make it in parts. Those that remember rows from step to step, as NewmarkImplicitSolver does
// accelerations, are refused: their memory would be that of other places.
//
// Nodes between two numbers of rigidCurvAbs, lengths from the opening, are held where they are: a rigid stretch, through which rods
// slide. There are nodes at its ends, and by `step` before and behind.
//
// startingPos is held: the opening. The nodes there are held by this component itself, whatever else holds them; indexFirstNode is the
// number of the one where the rods come in. Links in a scene find the number 0 there, one of the nodes that wait.
//
// Source: names, attributes, defaults and the choice of nodes are those of the plug-in BeamAdapter for SOFA. There nodes of rods that
// come out start in one place, and springs hold the opening; here they start where the rods have them at rest. There held nodes of a
// rod that is pushed alone go back along it in each step; here they stay, and the rod slides.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <WireRestShape name="guide" length="0.3" straightLength="0.25" spireDiameter="0.08" spireHeight="0" densityOfBeams="10 6"
//     radius="0.0005" radiusExtremity="0.0005" youngModulus="1e9" youngModulusExtremity="5e8" massDensity="1000"
//     massDensityExtremity="1000"/>
//   <EulerImplicitSolver newtonIterations="20" newtonTolerance="1e-10" rayleighStiffness="0.1" rayleighMass="0.1"/>
//   <SparseLDLSolver/>
//   <RegularGridTopology n="20 1 1" min="0 0 0" max="0.3 0 0"/>
//   <MechanicalObject template="Rigid3"/>
//   <WireBeamInterpolation name="wire" WireRestShape="@guide"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@wire"/>
//   <InterventionalRadiologyController instruments="@wire" xtip="0.05" speed="0.2" startingPos="0 0 0  0 0 0 1" threshold="0.001"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "components/beams/contact_sampling.h"
#include "components/beams/tip_motion.h"
#include "components/beams/wire_chain.h"
#include "framework/mechanics/history.h"
#include "framework/mechanics/projective_constraint.h"
#include "framework/mechanics/signs.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class InterventionalRadiologyController final : public ProjectiveConstraint, public History, public MovesRods {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void reset() override;
  void serialize(Archive& archive) override;
  bool isConstant() const override { return false; }
  bool projectsVelocity() const override { return true; }
  void addProjectors(double, std::vector<NodeProjector>& out) const override {
    for (Index node = 0; node < state().nodes(); ++node)
      if (node <= entry() || isHeld(std::size_t(node - entry())))
        for (const Index row : {2 * node, 2 * node + 1}) out.push_back({state().firstRow() + row, Mat3::Zero()});
  }
  void placeStart(double, Rows x, Rows v) const override;
  void moveRods(double t, double t_end) override;
  void askedAt(ConstRows x) override;
  void stepEnded(double) override;
  int contactEdges(bool all_out) const override;
  const std::vector<double>& history() const override { return is_.tips; }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  struct Pushed {
    std::vector<double> tips, turns;
    RodNodes nodes;
  };
  void findRods();
  void checkMesh() const;
  std::vector<PushedRod> rodsAt(const std::vector<double>& tips) const;
  Pushed pushedTo(std::vector<double> tips) const;
  Index entryOf(const Pushed& pushed) const { return state().nodes() - Index(pushed.nodes.at.size()); }
  Index entry() const { return entryOf(is_); }
  /// On a rigid stretch, and the rods were there before: a node that comes there finds its place first.
  bool isHeld(std::size_t n) const { return is_.nodes.is_held[n] && is_.nodes.at[n] <= before_.nodes.at.back() + threshold_; }
  RodSampling sampling() const { return {threshold_, rigid_, step_}; }
  void take(const Pushed& pushed) { is_ = before_ = pushed, xtip_ = written_ = pushed.tips, moved_.is_made = false; }
  bool isMovedFor(double t, double t_end) const;
  std::vector<double> asked() const;
  void checkWay() const;
  void moveControlled(double& tip, double t, double t_end) const;
  void giveBeams();
  void moveNodes();
  Placement formerAt(double at, const std::vector<Placement>& former, const std::vector<Vec3>& rates, std::array<Vec3, 2>& rate) const;
  Placement opening() const {
    return {Vec3(opening_[0], opening_[1], opening_[2]), Quaternion(opening_[6], opening_[3], opening_[4], opening_[5]).normalized()};
  }
  static std::array<Vec3, 2> still() { return {Vec3::Zero(), Vec3::Zero()}; }
  /// Into rows of the state.
  static void put(const Placement& placement, const std::array<Vec3, 2>& rate, Index node, Rows x, Rows v) {
    x[2 * node] = placement.centre, putNearest(placement.turn, x, 2 * node + 1);
    v[2 * node] = rate[0], v[2 * node + 1] = rate[1];
  }

  LinkList<WireChain> links_{"interpolation of a wire"};
  std::vector<WireChain*> rods_;
  std::vector<double> xtip_, turns_, opening_{0, 0, 0, 0, 0, 0, 1}, rigid_, curv_abs_, contact_at_;
  int controlled_ = 0, first_ = 0;
  double step_ = 0.1, angular_step_ = 3.1416 / 20, speed_ = 0, threshold_ = 0.01;
  FileName motion_file_;
  TipMotion motion_;
  Pushed start_, before_, is_;     ///< at the start of the run and of the step, and in the step
  std::vector<double> written_;    ///< what this component has put into xtip: another value is a program's
  std::vector<double> told_;       ///< the last one of these, or empty
  /// What moveRods() has done for a step.
  struct Moved {
    bool is_made = false;
    double from = 0, to = 0;       ///< of the step [s]
    std::vector<double> asked;     ///< what decides how rods move: xtip, turns, speed, dt
    std::vector<double> x;         ///< rows after it
    std::vector<double> before;    ///< and before it, where they are others
    Pushed pushed;                 ///< what it led to
    bool is_back = false;          ///< `is_` is for now that of before the step
  } moved_;
};

void InterventionalRadiologyController::declare(DataTable& table) {
  ProjectiveConstraint::declare(table);
  table.addLink("instruments", links_).help("the rods, the outermost first; the one of this node by default");
  table.add("xtip", xtip_).atOnce().help("how far the tip of each rod is out, along it").unit("m");
  table.add("rotationInstrument", turns_).atOnce().help("by how much each rod is turned about its axis").unit("rad");
  table.add("controlledInstrument", controlled_).atOnce().help("the rod that `speed` moves").min(0);
  table.add("speed", speed_).atOnce().help("of its tip; negative: back").unit("m/s");
  table.add("startingPos", opening_).help("the opening: x y z and a quaternion; the rods go along its x").inValuesOf(7);
  table.add("threshold", threshold_).help("nodes nearer to each other than that are one").unit("m").min(0, false);
  table.add("step", step_).help("how far from ends of rigid stretches there are nodes").unit("m").min(0, false);
  table.add("angularStep", angular_step_).help("SOFA's, of keys: programs set rotationInstrument").unit("rad");
  table.add("rigidCurvAbs", rigid_).help("pairs of lengths from the opening between which rods are fixed").unit("m");
  table.add("motionFilename", motion_file_).input().help("times [ms] and how far the tip goes in a step from then on, instead of speed");
  table.add("indexFirstNode", first_).help("the node at the opening").output();
  table.add("CurvAbs", curv_abs_).help("lengths from the opening where nodes are").unit("m").output();
  table.add("collisionCurvAbs", contact_at_).help("where points for contacts are, from the last tip back").unit("m").output();
  for (const char* name : {"topology", "fixedConstraint", "mainDirection", "handleEventTriggersUpdate"}) table.addVisualOnly(name);
}

void InterventionalRadiologyController::findRods() {
  rods_ = links_.all();
  if (rods_.empty())
    if (WireChain* only = find<WireChain>()) rods_.push_back(only);
  if (rods_.empty()) throw ComponentError("there are no rods to push", "instruments=\"@...\", WireBeamInterpolation components");
  for (WireChain* rod : rods_) {
    if (&rod->state() != &state())
      throw ComponentError(fmt::format("{} has beams between frames of {}", rod->path(), rod->state().path()),
                           fmt::format("beams between those of {}", state().path()));
    rod->followOf(*this);
  }
}

void InterventionalRadiologyController::checkMesh() const {
  const std::vector<Edge>& edges = rods_.front()->allEdges();
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (edges[e][0] != Index(e) || edges[e][1] != Index(e) + 1)
      throw ComponentError(fmt::format("edge {} of the mesh joins nodes {} and {}", e, edges[e][0], edges[e][1]),
                           "edges that join each node with the next, as of RegularGridTopology n=\"60 1 1\"");
  if (Index(edges.size()) + 1 != state().nodes())
    throw ComponentError(fmt::format("the mesh has {} edges for {} nodes", edges.size(), state().nodes()), "one less than nodes");
}

void InterventionalRadiologyController::init() {
  ProjectiveConstraint::init();
  findRods();
  checkMesh();
  if (!motion_file_.empty()) motion_.read(motion_file_);
  if (!motion_.empty() && speed_ != 0) warn("motionFilename and speed are given: the file moves the rod");
  if (rigid_.size() % 2 != 0 || !std::is_sorted(rigid_.begin(), rigid_.end()))
    throw ComponentError(fmt::format("rigidCurvAbs has {} lengths", rigid_.size()), "ascending ones, two for each rigid stretch");
  if (opening_.size() != 7) throw ComponentError(fmt::format("startingPos has {} numbers", opening_.size()), "x y z and a quaternion");
  if (controlled_ >= int(rods_.size()))
    throw ComponentError(fmt::format("controlledInstrument is {}", controlled_), fmt::format("0 to {}", rods_.size() - 1));
  for (std::vector<double>* list : {&xtip_, &turns_}) {
    if (list->size() > rods_.size())
      warn(fmt::format("{} has {} values for {} instruments: the last ones are left out", list == &xtip_ ? "xtip" : "rotationInstrument",
                       list->size(), rods_.size()));
    list->resize(rods_.size(), 0);
  }
  start_ = pushedTo(xtip_);
  take(start_), checkWay();
  first_ = 0;  // what links are to find
  giveBeams();
}

std::vector<PushedRod> InterventionalRadiologyController::rodsAt(const std::vector<double>& tips) const {
  std::vector<PushedRod> rods;
  for (std::size_t i = 0; i < rods_.size(); ++i) rods.push_back({&rods_[i]->shape(), tips[i]});
  return rods;
}

InterventionalRadiologyController::Pushed InterventionalRadiologyController::pushedTo(std::vector<double> tips) const {
  tips.resize(rods_.size(), 0);
  for (std::size_t i = 0; i < rods_.size(); ++i) tips[i] = std::min(tips[i], rods_[i]->wholeLength());
  Pushed pushed;
  pushed.nodes = sampleRods(rodsAt(tips), sampling());
  pushed.turns = turns_;
  pushed.turns.resize(rods_.size(), 0);
  if (Index(pushed.nodes.at.size()) > state().nodes())
    throw ComponentError(fmt::format("{}: the rods need {} nodes where their tips are, and {} has {}", path(), pushed.nodes.at.size(),
                                     state().path(), state().nodes()),
                         "a mesh with more nodes, or smaller numbers in densityOfBeams");
  pushed.tips = std::move(tips);
  return pushed;
}

/// Whether there are nodes for the rods wherever their tips may come to; an error where `speed` itself leads to it.
void InterventionalRadiologyController::checkWay() const {
  const std::vector<PushedRod> rods = rodsAt(start_.tips);
  MostNodes most;
  if (speed_ > 0) most = mostNodesOnWay(rods, std::size_t(controlled_), sampling());
  const bool is_led = Index(most.nodes) > state().nodes();
  if (!is_led) most = mostNodesAnywhere(rods, sampling());
  if (Index(most.nodes) <= state().nodes()) return;
  const std::string what = fmt::format("the rods need {} nodes where their tips are at {:.4g} m, and {} has {}", most.nodes,
                                       fmt::join(most.tips, " "), state().path(), state().nodes());
  const std::string more = fmt::format("a mesh of {} nodes, or smaller numbers in densityOfBeams", most.nodes);
  if (is_led) throw ComponentError(what + ": speed leads there", more);
  warn(what + ": a run that goes there ends with an error", more);
}

/// The beams of each rod between the nodes as they are in the step.
void InterventionalRadiologyController::giveBeams() {
  const std::vector<PushedRod> rods = rodsAt(is_.tips);
  for (std::size_t i = 0; i < rods_.size(); ++i) {
    std::vector<ChainBeam> beams = rods_[i]->noBeams();
    for (std::size_t n = 0; n + 1 < is_.nodes.at.size(); ++n) {
      const double from = is_.nodes.at[n], to = is_.nodes.at[n + 1];
      if (!rods[i].isAt(from, threshold_) || !rods[i].isAt(to, threshold_)) continue;
      ChainBeam& beam = beams[std::size_t(entry()) + n];
      beam.is_there = true;
      // what a node is beyond an end of the rod by less than the threshold: rods between two nodes are equally long
      const double before = std::clamp(from - rods[i].handle(), std::min(to - from - rods_[i]->wholeLength(), 0.), 0.);
      const double beyond = before + std::max(to - rods[i].tip, 0.);
      rods_[i]->shape().fill(beam, from - rods[i].handle() - beyond, to - rods[i].handle() - beyond);
      beam.axes_a = beam.axes_b = turnedBy(is_.turns[i] * Vec3::UnitX());
    }
    rods_[i]->setBeams(std::move(beams));
  }
  curv_abs_ = is_.nodes.at;
  contact_at_ = contactPlaces(rods, is_.nodes);
}

int InterventionalRadiologyController::contactEdges(bool all_out) const {
  std::vector<PushedRod> rods = rodsAt(start_.tips);
  if (!all_out) return stroma::contactEdges(rods);
  for (PushedRod& rod : rods) rod.tip = rod.shape->length();
  return int(contactPlaces(rods, sampleRods(rods, sampling())).size());
}

/// The rods lie as the outermost one does at rest.
void InterventionalRadiologyController::placeStart(double, Rows all_x, Rows all_v) const {
  const Rows x = state().segment(all_x), v = state().segment(all_v);
  Placement at = opening();
  for (Index node = 0; node <= entryOf(start_); ++node) put(at, still(), node, x, v);
  for (std::size_t n = 0; n + 1 < start_.nodes.at.size(); ++n) {
    const std::size_t edge = std::size_t(entryOf(start_)) + n;
    for (const WireChain* rod : rods_) {
      const ChainBeam& beam = rod->beams()[edge];
      if (!beam.is_there) continue;
      const Quaternion axes = at.turn * beam.axes_a;
      at = {at.centre + axes * beam.rest_way, axes * turnedBy(beam.rest_turn) * beam.axes_b.conjugate()};
      break;
    }
    put(at, still(), Index(edge) + 1, x, v);
  }
}

std::vector<double> InterventionalRadiologyController::asked() const {
  std::vector<double> all = xtip_;
  all.insert(all.end(), turns_.begin(), turns_.end());
  all.push_back(speed_), all.push_back(node().dt());
  return all;
}

/// Rods go all their way where a step begins. Integrators that make it in parts tell each of these, and again when it has been taken
/// back: x is then that of nodes as they are in the step. Where all of the step is made again, x is that of its start.
bool InterventionalRadiologyController::isMovedFor(double t, double t_end) const {
  if (!moved_.is_made || t < moved_.from || t_end > moved_.to) return false;
  const Rows x = state().x();
  return t > moved_.from || (moved_.asked == asked() && std::equal(moved_.x.begin(), moved_.x.end(), x.data));
}

void InterventionalRadiologyController::moveControlled(double& tip, double t, double t_end) const {
  tip = motion_.empty() ? tip + speed_ * (t_end - t) : motion_.next(tip, t);
  if (speed_ < 0) tip = std::max(tip, 0.);
}

void InterventionalRadiologyController::moveRods(double t, double t_end) {
  if (!(t_end > t) || isMovedFor(t, t_end)) return;  // the first: where a run starts
  std::vector<double> tips = before_.tips;
  xtip_.resize(rods_.size(), 0);
  if (xtip_ != written_) told_ = xtip_;
  for (std::size_t i = 0; i < tips.size(); ++i)
    if (xtip_[i] != written_[i]) tips[i] = xtip_[i];
  moveControlled(tips[std::min(std::size_t(controlled_), tips.size() - 1)], t, t_end);
  moved_.is_made = false;
  for (std::size_t i = 0; i < rods_.size(); ++i) tips[i] = std::min(tips[i], rods_[i]->wholeLength());
  turns_.resize(rods_.size(), 0);
  const bool moves = tips != before_.tips || turns_ != before_.turns;
  if (!moves && is_.tips == before_.tips && is_.turns == before_.turns) return;
  is_ = pushedTo(std::move(tips));
  const ConstRows x = state().x();
  std::vector<double> before(x.data, x.data + x.doubles());
  if (moves) moveNodes();
  giveBeams();
  std::vector<double> after(x.data, x.data + x.doubles());
  if (after == before) before.clear();
  moved_ = {true, t, t_end, asked(), std::move(after), std::move(before), is_, false};
}

void InterventionalRadiologyController::askedAt(ConstRows x) {
  if (!moved_.is_made || moved_.before.empty()) return;
  const bool is_before = std::equal(moved_.before.begin(), moved_.before.end(), x.data);
  if (is_before == moved_.is_back) return;
  moved_.is_back = is_before;
  is_ = is_before ? before_ : moved_.pushed;
  giveBeams();
}

/// Where something was at a length from the opening, and how it moved, by the nodes of before.
Placement InterventionalRadiologyController::formerAt(double at, const std::vector<Placement>& former, const std::vector<Vec3>& rates,
                                                      std::array<Vec3, 2>& rate) const {
  const std::vector<double>& places = before_.nodes.at;
  std::size_t n = 0;
  while (n + 1 < places.size() && places[n] + threshold_ <= at) ++n;
  if (n == 0 || std::abs(places[n] - at) < threshold_) {
    rate = {rates[2 * n], rates[2 * n + 1]};
    return former[n];
  }
  const double length = places[n] - places[n - 1], s = std::min((at - places[n - 1]) / length, 1.);
  for (const std::size_t k : {0, 1}) rate[k] = (1 - s) * rates[2 * n - 2 + k] + s * rates[2 * n + k];
  return between(former[n - 1], former[n], length, s);
}

void InterventionalRadiologyController::moveNodes() {
  const Rows x = state().x(), v = state().v();
  std::vector<Placement> former;
  std::vector<Vec3> rates;
  for (Index node = entryOf(before_); node < state().nodes(); ++node) {
    former.push_back({x[2 * node], orientationIn(x, 2 * node + 1)});
    rates.push_back(v[2 * node]), rates.push_back(v[2 * node + 1]);
  }
  const std::vector<double> places = formerPlaces(is_.nodes, is_.nodes.at.back() - before_.nodes.at.back());
  for (Index node = 0; node <= entry(); ++node) put(opening(), still(), node, x, v);
  for (std::size_t n = 1; n < places.size(); ++n) {
    std::array<Vec3, 2> rate = still();
    const Placement at = formerAt(places[n], former, rates, rate);
    if (isHeld(n)) rate = still();
    put(at, rate, entry() + Index(n), x, v);
  }
}

void InterventionalRadiologyController::stepEnded(double) {
  if (moved_.is_made && moved_.is_back) is_ = moved_.pushed, giveBeams();
  before_ = is_;
  xtip_ = written_ = is_.tips;
  first_ = int(entry());
  moved_.is_made = false;
}

/// What a program has set stays set: the first step goes there.
void InterventionalRadiologyController::reset() {
  if (xtip_ != written_) told_ = xtip_;
  take(start_), giveBeams();
  if (!told_.empty()) xtip_ = told_;
}

void InterventionalRadiologyController::serialize(Archive& archive) {
  std::vector<double> wanted = xtip_, started = start_.tips;
  archive.list("start", started);
  archive.list("tips", before_.tips);
  archive.list("wanted", wanted);
  archive.list("told", told_);
  if (!archive.isReading()) return;
  take(pushedTo(before_.tips));
  giveBeams();
  xtip_ = started == start_.tips ? wanted : start_.tips;  // a scene that is written with other tips goes on to these
  first_ = int(entry());
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(interventional_radiology_controller) {
  factory.add<stroma::InterventionalRadiologyController>("InterventionalRadiologyController", "pushes and turns catheters and guide wires");
}
