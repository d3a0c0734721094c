// SPDX-License-Identifier: LGPL-2.1-or-later
// What averages at the nodes (nodal_dilatation.h) do alike for all methods with the same data: compiled once for each kind
// of data, in nodal_averages.cpp.
#pragma once
#include <map>

#include "components/elasticity/averaged_models.h"
#include "components/elasticity/tetrahedron_kernels.h"

namespace stroma::tetrahedron {

/// `Storage`: of fans of a model of averaged_models.h.
template <class Storage>
class NodalAverages : public ElementKernels {
 public:
  explicit NodalAverages(const Elements& elements);
  bool refill() override;
  void addPattern(BlockPattern& pattern) const override;
  /// For each material those of its elements, then those of its patches.
  std::vector<Index> slots(const BlockMatrix& matrix) const override;
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override;
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override;

 protected:
  using Cells = AveragedCells<Storage>;
  using Rest = std::remove_cvref_t<decltype(std::declval<Storage&>().rest[0].of[0])>;
  using Tangent = std::remove_cvref_t<decltype(std::declval<Storage&>().tangent[0].of[0])>;
  using FanTangent = Fanned<Tangent>;
  using Nodes = V3<Pack>[fan_nodes];
  using Matrix = typename ElementLoop<fan_nodes, FanCoupling>::Matrix;
  /// d(V_0 tr(eps))/dx of the last three nodes of each tetrahedron of a fan.
  using Derivatives = Gradients<Pack>[fan_size];
  static constexpr bool exact = requires(Tangent tangent) { tangent.pressure; };

  /// K of a batch at the last force, of its elements alone; here that of the warped tangent.
  virtual void matrix(const Cells& m, Index b, Matrix& k) const;
  /// Of the exact tangent.
  virtual void differentiate(const Cells& m, Index b, Derivatives& out) const;

  void keep(ConstRows x);
  /// Only rows of this material are read.
  void startSums(const Cells& m, Index rows) const;
  /// The part of the elements alone with the tangent warped, and the changes of their volumes into sums_.
  void addWarpedProduct(const Cells& m, ConstRows dx, double factor, Rows df) const;
  /// f -= V_e p_e g_i, p_e the mean of c_a times the sums at the nodes.
  void addPressures(const Cells& m, double factor, Rows f) const;
  /// After addPressures() of a force.
  void keepPressures(Cells& m) const;
  /// sum + the energy of sums_.
  double withEnergyOfSums(double sum, const Cells& m) const;
  /// A quarter of each tetrahedron's volume change to each of its nodes.
  static void spread(Pack first, Pack second, Nodes& out) {
    const Pack quarter(0.25), none(0.), a = first * quarter, b = second * quarter, both = a + b;
    out[0] = {both, none, none}, out[1] = {both, none, none}, out[2] = {a, none, none};
    out[3] = {both, none, none}, out[4] = {b, none, none};
  }

  mutable std::vector<Cells> materials_;  ///< mutable for the patches, which a scene without a matrix does not make
  Vector x_;                              ///< of the last force, for the exact tangent
  mutable Vector sums_;  ///< x: sum of V_e/4 tr(eps_e), then pressures, of one material at a time
  mutable bool gradients_ready_ = false;

 private:
  struct Warped;
  void preparePatches() const;
  void updatePatches() const;

  // ---- for other constants ----
  const TetrahedronShapes& shapes_;
  Index first_row_;
  LameOf lame_;
  std::map<double, std::vector<Index>> cells_;  ///< of the mesh, by their bulk modulus
  std::vector<std::vector<Fan>> fans_;          ///< of each material, with cells and nodes of the mesh
};

}  // namespace stroma::tetrahedron
