// SPDX-License-Identifier: LGPL-2.1-or-later
// AdaptiveBeamMass: the consistent mass of the beams of every AdaptiveBeamForceFieldAndMass in its node. A node gets it by itself.
//
//   M = sum over beams of R m R^T
//
// with m the mass matrix of a straight beam of Euler and Bernoulli with the inertia of sections that turn, and R the axes half way
// between those of its ends. M follows the beams as they turn, and as a rod comes out. Weight is the matter of the force fields.
// Forces by the change of M as it turns are those of the field, by which momentum and angular momentum stay as they are; where its
// turningForces is false there are none, as in the plug-in.
//
// Source: the matrix is the one of the plug-in BeamAdapter for SOFA, whose force field is a mass at the same time; J. S. Przemieniecki,
// "Theory of matrix structural analysis", 1968, chapter 11.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology edges="0 1  1 2"/>
//   <MechanicalObject template="Rigid3" position="0 0 0  0 0 0 1   0.5 0 0  0 0 0 1   1 0 0  0 0 0 1"/>
//   <BeamInterpolation name="beams" radius="0.01" defaultYoungModulus="1e9" defaultPoissonRatio="0.3"/>
//   <AdaptiveBeamForceFieldAndMass interpolation="@beams" massDensity="1000"/>
//   <AdaptiveBeamMass rayleighMass="0.1"/>
//   <FixedProjectiveConstraint indices="0"/>
// </Node>
#include <algorithm>
#include <iterator>

#include "components/beams/beam_inertia.h"
#include "framework/mechanics/mass.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class AdaptiveBeamMass final : public Mass {
 public:
  void init() override {
    std::vector<HasBeamInertia*> inertias;
    for (const auto& other : node().components())
      if (auto* field = dynamic_cast<HasBeamInertia*>(other.get())) {
        other->ensureReady();
        if (field->inertia()) inertias.push_back(field);
      }
    if (isMadeForAnother() && !inertias.empty()) mstate_.set(&inertias.front()->chain().state());
    Mass::init();
    fields_.clear();
    std::ranges::copy_if(inertias, std::back_inserter(fields_), [this](auto* each) { return &each->chain().state() == &state(); });
    if (fields_.empty())
      throw ComponentError("there are no beams of " + state().path() + " with a mass in this node",
                           "an AdaptiveBeamForceFieldAndMass with computeMass=\"true\"");
    for (HasBeamInertia* field : fields_) field->tellMass = [this] { shareOut(); };
    shareOut();
  }

  const std::vector<double>& lumped() const override {
    for (HasBeamInertia* field : fields_) field->inertia();  // updates it after changes
    return lumped_;
  }
  const std::vector<double>& rowSums() const override { return none_; }
  bool isDiagonal() const override { return false; }

  void addProduct(ConstRows p, double factor, Rows out) const override {
    forEachBeam([&](const Rows4& rows, const DenseTangent<4>& m) { m.addProduct(rows, p, factor, out); });
  }
  void addPattern(BlockPattern& pattern) const override {
    for (HasBeamInertia* field : fields_)
      for (const ChainBeam& beam : field->chain().beams()) {
        const Rows4 rows = rowsOf(beam);
        pattern.addClique(rows.data(), 4);
      }
  }
  void prepareAssembly(const BlockMatrix& matrix) override {
    slots_.clear();
    for (HasBeamInertia* field : fields_)
      for (const ChainBeam& beam : field->chain().beams())
        for (const Index row : rowsOf(beam))
          for (const Index column : rowsOf(beam)) slots_.push_back(matrix.slot(row, column));
  }
  void addTo(double factor, BlockMatrix& matrix) const override {
    std::size_t slot = 0;
    forEachBeam([&](const Rows4&, const DenseTangent<4>& m) {
      for (const Mat3& block : m.blocks) matrix.add(slots_[slot++], factor * block);
    });
  }
  void addDiagonal(double factor, std::vector<double>& blocks) const override {
    forEachBeam([&](const Rows4& rows, const DenseTangent<4>& m) {
      for (int r = 0; r < 4; ++r)
        for (int k = 0; k < 9; ++k) blocks[std::size_t(rows[std::size_t(r)]) * 9 + std::size_t(k)] += factor * m.block(r, r)(k / 3, k % 3);
    });
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  using Rows4 = std::array<Index, 4>;
  Rows4 rowsOf(const ChainBeam& beam) const {
    const Index a = state().firstRow() + 2 * beam.a, b = state().firstRow() + 2 * beam.b;
    return {a, a + 1, b, b + 1};
  }
  template <class Visit>
  void forEachBeam(Visit&& visit) const {
    for (HasBeamInertia* field : fields_) {
      const BeamInertia& inertia = *field->inertia();
      const std::vector<DenseTangent<4>>& blocks = inertia.blocks();
      for (std::size_t i = 0; i < blocks.size(); ++i) visit(inertia.rows()[i], blocks[i]);
    }
  }
  /// Every node an equal share of the whole rod, out or not; of a turn that of a beam as long as the others.
  void shareOut() {
    lumped_.assign(std::size_t(state().size()), 0);
    none_.assign(lumped_.size(), 0);
    for (HasBeamInertia* field : fields_) {
      const std::vector<ChainBeam>& beams = field->chain().beams();
      std::vector<char> is_of(std::size_t(state().nodes()), 0);
      for (const ChainBeam& beam : beams) is_of[std::size_t(beam.a)] = is_of[std::size_t(beam.b)] = 1;
      const double share = field->wholeMass() / double(std::count(is_of.begin(), is_of.end(), 1));
      const double usual = field->chain().wholeLength() / double(beams.size());
      for (std::size_t node = 0; node < is_of.size(); ++node)
        if (is_of[node]) lumped_[2 * node] += share, lumped_[2 * node + 1] += share * usual * usual / 105;
    }
    // M turns with the beams: no tensor of a body has it, and one that is the same about all axes says so
    for (Index row = 1; row < state().size(); row += 2)
      if (const double inertia = lumped_[std::size_t(row)]; inertia > 0)
        return setTurningInertias({{row, inertia * Mat3::Identity(), false}});
  }

  std::vector<HasBeamInertia*> fields_;
  std::vector<double> lumped_, none_;
  std::vector<Index> slots_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(adaptive_beam_mass) {
  factory.add<stroma::AdaptiveBeamMass>("AdaptiveBeamMass", "the consistent mass of a chain of beams");
}
