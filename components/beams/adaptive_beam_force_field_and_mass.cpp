// SPDX-License-Identifier: LGPL-2.1-or-later
// AdaptiveBeamForceFieldAndMass: elasticity, inertia and weight of the beams of a BeamInterpolation or a WireBeamInterpolation, for
// turns of any size and small strains.
//
// With (rho, psi) as the twist that leads along a helix from the axes of one end to those of the other, and rho_0, psi_0 at rest,
//
//   E = EA/2L (rho_x - rho_0x)^2 + 6 EIz/L^3 (rho_y - rho_0y)^2 + 6 EIy/L^3 (rho_z - rho_0z)^2
//     + GJ/2L (psi_x - psi_0x)^2 + EIy/2L (psi_y - psi_0y)^2 + EIz/2L (psi_z - psi_0z)^2,   G = E/(2 (1 + nu))
//
// which is the matrix of Euler and Bernoulli for small displacements. An arc of any angle below half a turn has no stretch, so that
// the plug-in's reinforceLength has nothing to do here. The mass is the consistent one of Euler and Bernoulli with the inertia of
// sections that turn, in the axes half way between those of the ends; the weight is that of the cubic curve between the frames,
//
//   V = -m g.((c_a + c_b)/2 + L/12 (t_a - t_b)),   t: x axes of the ends,   m = massDensity A L
//
// With the turn by t about n from one end to the other, g = n tan(t/4), the middle axes turn by w = (w_a + w_b)/2 - g/2 x (w_b - w_a), and
// M with them. With p = M v and p_r, v_r, w_r of the rows of a beam, c = 1/2 sum_r p_r x v_r:
//
//   f_r -= w x p_r - (M (w x v))_r,    torques of the ends += c - g x c - p_a x w_a,   c + g x c - p_b x w_b
//
// by which momenta stay and energy is kept. They are taken from the velocities of each evaluation; their derivatives are left out.
// Without turningForces they are zero, as in the plug-in.
//
// The inertia is that of a component AdaptiveBeamMass, which the node gets by itself unless computeMass is false. The density is
// massDensity, or with instrumentParameters, or where massDensity is not given, that of the rod where it has one.
//
// Source: names, attributes and defaults are those of the plug-in BeamAdapter for SOFA, and the matrices at rest. It has the
// displacements of the ends in the axes of the middle of the curve in the place of the twist: the same to first order.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology edges="0 1  1 2"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0.5 0 0  0 0 0 1   1 0 0  0 0 0 1"/>
//   <BeamInterpolation name="beams" radius="0.01" defaultYoungModulus="1e9" defaultPoissonRatio="0.3"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@beams" massDensity="1000"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/beams/beam_inertia.h"
#include "components/beams/frame_pair_field.h"
#include "components/beams/rod_shape.h"
#include "components/beams/twist_wrench.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/usual_component.h"
#include "framework/simulation/integrator.h"

namespace stroma {
namespace {

class AdaptiveBeamForceFieldAndMass final : public FramePairFieldOf<AdaptiveBeamForceFieldAndMass>,
                                            public HasBeamInertia,
                                            public StepListener,
                                            public CorrectsStart {
 public:
  void declare(DataTable& table) override {
    FramePairField::declare(table);
    table.addLink("interpolation", link_).help("the beams; those of this node by default");
    table.addLink("instrumentParameters", parameters_).help("the shape of the rod, whose density is to be taken");
    table.add("computeMass", has_mass_).help("with inertia and weight");
    table.add("turningForces", turns_)
        .help("with the gyroscopic forces that conserve momentum as the inertia of beams rotates");
    table.add("massDensity", density_).recompiled().help("of the rod").unit("kg/m^3").min(0, false);
    table.add("reinforceLength", reinforced_).help("SOFA's; without effect: elongation is measured along the bent beam anyway");
    table.add("shearStressComputation", shears_).help("SOFA's; only true is supported");
    table.addVisualOnly("tolerance");
  }

  std::string missingPartner() const override {
    if (!has_mass_) return {};
    for (const auto& other : node().components())
      if (other->type() == "AdaptiveBeamMass") return {};
    return "AdaptiveBeamMass";
  }

  void init() override {
    ForceField::init();
    if (!shears_)
      throw ComponentError("shearStressComputation is false: forces by stretch and twist of the curve alone are not supported",
                           "shearStressComputation=\"true\"");
    chain_ = link_.get();
    if (!chain_ && !link_.target()) chain_ = find<BeamChain>();
    if (!chain_) throw ComponentError("there are no beams", "interpolation=\"@...\", or a BeamInterpolation in this node");
    if (&chain_->state() != &state())
      throw ComponentError(fmt::format("{} has beams between frames of {}", chain_->path(), chain_->state().path()),
                           fmt::format("beams between those of {}", state().path()));
    makePairs();
    if (parameters_.get()) parameters_.get()->ensureReady();
    if (has_mass_) warnOfDensity();
  }

  void compile() override {
    chain_->checkBeams();
    is_pushed_ = chain_->isPushed();
    known_ = -1;
    FramePairField::compile();
    follow();
    tellMass();
  }

  void stepBegins(ConstRows, double t, double t_end) override {
    chain_->stepBegins(t, t_end);
    follow();
    const ConstRows now = state().x();
    start_.assign(now.data, now.data + (is_pushed_ ? now.doubles() : 0));
  }
  /// What an integrator remembers of each row would be of other places than those where nodes of a rod are then. Forces of constraint
  /// are only what Newton's method starts from.
  void placeStart(Rows, Index independent, const std::function<void(Rows)>&) override {
    Integrator* integrator = is_pushed_ ? find<Integrator>() : nullptr;
    if (!integrator) return;
    Archive memory;
    integrator->serialize(memory);
    const std::size_t all = std::size_t(independent) * row_doubles * sizeof(double);
    for (const auto& [name, entry] : memory.entries())
      if (entry.kind == Archive::Kind::real && entry.bytes.size() == all && !name.ends_with("forces_of_constraint"))
        throw ComponentError(fmt::format("it remembers the {} of each node from step to step, and nodes of {} get other places on the rod",
                                         name.substr(name.find(':') + 1), chain_->path()),
                             usualComponent(Part::integrator) + " newtonIterations=\"30\"");
  }
  BeamInertia* inertia() override {
    if (!has_mass_) return nullptr;
    if (state().isBound()) chain_->askedAt(state().x());
    follow();
    return &inertia_;
  }
  const BeamChain& chain() const override { return *chain_; }
  double wholeMass() const override {
    double mass = 0;
    for (const ChainBeam& part : chain_->wholeRod()) mass += densityOf(part) * part.section.area * part.length;
    return mass;
  }

  double energy(ConstRows x) const override {
    chain_->askedAt(state().segment(x));
    self_->follow();
    const bool was_pressed = is_pressed_;
    const double sum = FramePairFieldOf::energy(x) + weightEnergy(x);
    is_pressed_ = was_pressed;
    return sum;
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    chain_->askedAt(state().segment(x));
    follow();
    const ConstRows own = state().segment(x);
    is_pressed_ = own.doubles() == start_.size() && std::equal(start_.begin(), start_.end(), own.data);
    FramePairField::addForce(x, v, f);
    if (!has_mass_) return;
    inertia_.place(x);
    addWeight(x, f);
    if (turns_) inertia_.addTurning(v, f);
  }

  ForceTraits traits() const override {
    ForceTraits traits = FramePairField::traits();
    traits.conservative = !(has_mass_ && turns_);  // forces of turning inertia are no gradient
    traits.exact_tangent = traits.has_rest_shape = !is_pushed_;
    traits.forces_balance = traits.torques_balance = !has_mass_;
    return traits;
  }

  std::string worstElement(ConstRows x) const override {
    self_->follow();
    std::size_t worst = 0;
    double most = -1;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const ChainBeam& beam = chain_->beams()[i];
      if (!beam.is_there) continue;
      const double strain = std::abs((x[rows_[i][2]] - x[rows_[i][0]]).norm() / beam.length - 1);
      if (strain > most) most = strain, worst = i;
    }
    if (most < 0) return {};
    const ChainBeam& beam = chain_->beams()[worst];
    return fmt::format("beam {} (nodes {} {}): its ends are {:.4g} m from each other, and it is {:.4g} m long", worst, beam.a, beam.b,
                       (x[rows_[worst][2]] - x[rows_[worst][0]]).norm(), beam.length);
  }

 protected:
  double drawnRadius() const override { return chain_->beams().empty() ? 0 : chain_->beams().back().section.radius; }

 private:
  friend FramePairFieldOf;

  void makePairs() {
    std::vector<Pair> pairs;
    for (const ChainBeam& beam : chain_->beams()) pairs.push_back({2 * beam.a, 2 * beam.b, beam.axes_a, beam.axes_b, 0});
    setPairs(std::move(pairs));
  }
  /// Of the rod that a beam is of, or that is named: where there is none, massDensity.
  std::optional<double> ownDensityOf(const ChainBeam& beam) const {
    return parameters_.target() ? parameters_.get()->stretchAt(beam.to).section.density : beam.section.density;
  }
  double densityOf(const ChainBeam& beam) const {
    const bool by_rod = parameters_.target() || !data().find("massDensity")->isSet();
    return (by_rod ? ownDensityOf(beam) : std::nullopt).value_or(density_);
  }
  void warnOfDensity() const {
    for (const ChainBeam& beam : chain_->beams())
      if (beam.is_there && !ownDensityOf(beam) && !data().find("massDensity")->isSet())
        return warn(fmt::format("massDensity is not given: the default {:g} kg/m^3 is used", density_));
  }

  /// Takes over what the chain's beams are now.
  void follow() {
    if (known_ == chain_->revision()) return;
    known_ = chain_->revision();
    const std::vector<ChainBeam>& beams = chain_->beams();
    if (!is_pushed_) tellMass();  // no attribute of a rod that is pushed changes what it is made of
    makePairs();
    placeAxes();
    std::vector<double> densities;
    for (const ChainBeam& beam : beams) densities.push_back(densityOf(beam));
    if (has_mass_) {
      const std::size_t before = std::size_t(state().firstRow());
      inertia_.set(beams, densities, state().firstRow());
      if (state().isBound()) inertia_.place({state().x().data - before * row_doubles, Index(before) + state().size()});
    }
    const auto twistAtRest = [&](std::size_t i, std::size_t k) {
      if (!beams[i].is_there) return 0.;
      return k < 3 ? (dexpInverse(beams[i].rest_turn) * beams[i].rest_way)[Index(k)] : beams[i].rest_turn[Index(k - 3)];
    };
    rest_ = lanesOf<6>(beams.size(), twistAtRest);
    stiff_ = lanesOf<6>(beams.size(), [&](std::size_t i, std::size_t k) { return beams[i].is_there ? stiffnessOf(beams[i], k) : 0; });
  }
  static double stiffnessOf(const ChainBeam& beam, std::size_t k) {
    const RodSection& s = beam.section;
    const double l = beam.length;
    const double of[6] = {s.young * s.area, 12 * s.young * s.about_z / (l * l), 12 * s.young * s.about_y / (l * l),
                          s.shearModulus() * s.polar(), s.young * s.about_y, s.young * s.about_z};
    return of[k] / l;
  }

  // ---- weight ----
  /// t_a and t_b of a beam.
  std::array<Vec3, 2> tangents(std::size_t i, ConstRows x) const {
    const ChainBeam& beam = chain_->beams()[i];
    return {orientationIn(x, rows_[i][1]) * (beam.axes_a * Vec3::UnitX()), orientationIn(x, rows_[i][3]) * (beam.axes_b * Vec3::UnitX())};
  }
  double lever(std::size_t i) const { return inertia_.massOf(i) * chain_->beams()[i].length / 12; }
  double weightEnergy(ConstRows x) const {
    const Vec3 g = node().gravity();
    double sum = 0;
    for (std::size_t i = 0; has_mass_ && !g.isZero(0) && i < rows_.size(); ++i) {
      const auto [t_a, t_b] = tangents(i, x);
      sum -= g.dot(inertia_.massOf(i) / 2 * (x[rows_[i][0]] + x[rows_[i][2]]) + lever(i) * (t_a - t_b));
    }
    return sum;
  }
  void addWeight(ConstRows x, Rows f) {
    const Vec3 g = node().gravity();
    tangents_.assign(g.isZero(0) ? 0 : rows_.size(), {});
    for (std::size_t i = 0; i < tangents_.size(); ++i) {
      tangents_[i] = tangents(i, x);
      for (const std::size_t end : {0, 1}) {
        f[rows_[i][2 * end]] += inertia_.massOf(i) / 2 * g;
        f[rows_[i][2 * end + 1]] += (end == 0 ? lever(i) : -lever(i)) * tangents_[i][end].cross(g);
      }
    }
  }
  void computeTangents() const override {
    FramePairFieldOf::computeTangents();
    const Vec3 g = node().gravity();
    for (std::size_t i = 0; i < tangents_.size(); ++i)
      for (const int end : {0, 1}) {
        const Vec3& t = tangents_[i][std::size_t(end)];
        const Mat3 turned = 0.5 * (t * g.transpose() + g * t.transpose()) - t.dot(g) * Mat3::Identity();
        stiffness_[i].block(2 * end + 1, 2 * end + 1) += (end == 0 ? lever(i) : -lever(i)) * turned;
      }
  }

  /// A rod that is pushed starts each step with a beam that is far too short or too long, and its exact stiffness would have no
  /// solution to go to. At that start, and where the thrust of one of its beams is above EI/L^2, all have the stiffness without
  /// that of thrust and couples, which is definite: with neighbours that keep theirs it is not.
  template <class T>
  Wrench<T> evaluate(std::size_t batch, const Triple<T>& p, const Triple<T>& psi, const InverseTerm<Pack>& term) const {
    const LanesOf<6>&rest = rest_[batch], &stiff = stiff_[batch];
    const auto change = [&](const T& now, std::size_t k) { return now - T(packOf(rest[k])); };
    const auto pull = [&](const T& by, std::size_t k) { return T(packOf(stiff[k])) * by; };
    const T square = dot(psi, psi);
    const T c = stroma::chain(square, term.c, term.c1), slope = stroma::chain(square, 2. * term.c1, 2. * term.c2);
    const Triple<T> rho = inverseTimes(psi, c, p);
    const Triple<T> shift{change(rho.x, 0), change(rho.y, 1), change(rho.z, 2)};
    const Triple<T> turn{change(psi.x, 3), change(psi.y, 4), change(psi.z, 5)};
    const Triple<T> s{pull(shift.x, 0), pull(shift.y, 1), pull(shift.z, 2)};
    const Triple<T> couple{pull(turn.x, 3), pull(turn.y, 4), pull(turn.z, 5)};
    Wrench<T> wrench;
    if constexpr (std::is_same_v<T, PackJet>) {
      if (is_pressed_) {
        setTwistWrench(still(p), still(psi), PackJet(c.value), PackJet(slope.value), PackJet(square.value), s, couple, wrench);
        for (Triple<T>* each : {&wrench.n, &wrench.k}) each->x.value = each->y.value = each->z.value = Pack(0.);
        return wrench;
      }
    } else {
      is_pressed_ = is_pressed_ || (is_pushed_ && any(s.x * packOf(rest[0]) < -packOf(stiff[4])));
    }
    setTwistWrench(p, psi, c, slope, square, s, couple, wrench);
    wrench.energy = 0.5 * (valueOf(dot(s, shift)) + valueOf(dot(couple, turn)));
    return wrench;
  }
  static Triple<PackJet> still(const Triple<PackJet>& of) { return {PackJet(of.x.value), PackJet(of.y.value), PackJet(of.z.value)}; }

  Link<BeamChain> link_{"interpolation of beams"};
  Link<RodShape> parameters_{"shape of a rod"};
  bool has_mass_ = true, turns_ = true, shears_ = true, reinforced_ = false;
  double density_ = 1;
  BeamChain* chain_ = nullptr;
  long known_ = -1;                              ///< revision of the chain that what follows is of
  bool is_pushed_ = false;                       ///< by a controller
  std::vector<double> start_;                    ///< rows where a step of a rod that is pushed begins
  mutable bool is_pressed_ = false;              ///< the last force was there, or a beam had a thrust above EI/L^2
  std::vector<LanesOf<6>> rest_, stiff_;         ///< rho_0, psi_0 and the six stiffnesses of each batch
  AdaptiveBeamForceFieldAndMass* const self_ = this;  ///< what it has of the beams follows from them, whenever it is asked for
  BeamInertia inertia_;
  std::vector<std::array<Vec3, 2>> tangents_;    ///< of the last addForce(), with a weight
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(adaptive_beam_force_field_and_mass) {
  factory.add<stroma::AdaptiveBeamForceFieldAndMass>("AdaptiveBeamForceFieldAndMass", "elasticity, inertia and weight of a chain of beams");
}
