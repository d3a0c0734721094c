// SPDX-License-Identifier: LGPL-2.1-or-later
// Loads that follow a surface. With A_a the area vector of a node of a face (area_vectors.h), dA_a = sum_b w_ab x dx_b,
// a stress S, the same everywhere, and a weight c of the face:
//
//   f_a = c S A_a,   df_a/dx_b = c S [w_ab]x
//
// The resultant is the load on the whole surface exactly, and a uniform S on a closed surface has neither a resultant
// nor a moment. S = p I on a closed surface of weight 1 has the potential -p V, so that its tangent is symmetric once
// it is summed, and the symmetric part of each face is as good. On an open surface what is not symmetric lies in the
// blocks of the nodes on its rim: where the rim is held, the symmetric part is the derivative too. Where it can move, the symmetric
// part costs iterations of Newton's method: of a bar of 4 x 1 x 1, E = 3 kPa, held at one end, with p on its long upper side in one
// step of statics, 10, 18 and 56 for p = 5, 20 and 60 Pa, against 7, 12 and 17 with tangent = exact. On a closed cavity both are one.
// A solve that fails goes on with the exact one, unless the scene names a tangent or the linear solver takes symmetric ones only.
#pragma once
#include "framework/mechanics/local_load.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/closed_surface.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// Tangent of a face; that of a triangle has 3 x 3 blocks.
constexpr int face_nodes = int(most_face_nodes);
struct FaceTangent : DenseTangent<face_nodes> {
  int corners = face_nodes;
  /// Instead of that of DenseTangent, whose caller knows the type.
  // NOLINTNEXTLINE(bugprone-derived-method-shadowing-base-method)
  void addProduct(const std::array<Index, most_face_nodes>& rows, ConstRows dx, double factor, Rows df) const {
    for (int i = 0; i < corners; ++i) {
      Vec3 sum = Vec3::Zero();
      for (int j = 0; j < corners; ++j) sum += block(i, j) * dx[rows[j]];
      df[rows[i]] += factor * sum;
    }
  }
};

class SurfaceLoad : public NodeGroupField<face_nodes, FaceTangent>, public LocalLoad, public OpenChoices {
 public:
  void declare(DataTable& table) override;  ///< topology, tangent
  ForceTraits traits() const override;
  void compile() override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  bool isDeadLoadToFirstOrder() const override { return stress_is_fixed && !traits().linear; }
  void addLoadedRows(std::vector<Index>& rows) const override;
  bool useExactTangent(bool exact) override;

 protected:
  void computeTangents() const override;
  /// The mesh that `topology` names, else the one of this node or the nearest above; of the state's nodes.
  const Mesh& surfaceMesh() const;
  /// Called in init(), with at least one face. `weights`: c of each face [-], empty: 1.
  void setFaces(std::vector<Face> faces, std::vector<double> weights = {});
  const std::vector<Face>& faces() const { return faces_; }
  /// Every edge is run through as often in one direction as in the other.
  bool isClosed() const { return open_edge_.empty(); }
  /// Nodes of an edge on the rim, "3 7"; empty when closed.
  const std::string& openEdge() const { return open_edge_; }
  bool isWeighted() const { return !weights_.empty(); }
  /// S [Pa] when the nodes are at x.
  virtual Mat3 stress(ConstRows x) const = 0;
  /// S = p I, p the same on all faces, on a closed surface.
  virtual bool hasPotential() const = 0;
  /// Behind the closed surface [m^3]; rows of the system.
  double volume(ConstRows x) const;
  /// The same at rest.
  double restVolume() const;
  bool has_tangent = true;      ///< false: K = 0
  std::size_t rigid_faces = 0;  ///< the last faces, as many of them, have no part in K
  bool stress_is_fixed = true;  ///< S does not depend on x

 private:
  enum class TangentWord : int { symmetric, exact };

  bool isExact() const { return (tangent_ == TangentWord::exact || is_exact_for_solve_) && !hasPotential(); }
  double weight(std::size_t face) const { return weights_.empty() ? 1 : weights_[face]; }

  TopologyLink topology_;
  TangentWord tangent_ = TangentWord::symmetric;
  bool is_exact_for_solve_ = false;  ///< useExactTangent()
  std::vector<Face> faces_;
  std::vector<double> weights_;
  std::string open_edge_;

  // what the tangents are made of, when somebody asks for them
  std::vector<area_vectors::Corners> corners_;  ///< positions of the last force [m], shape (faces)
  Mat3 last_stress_ = Mat3::Zero();             ///< S of the last force [Pa]
};

}  // namespace stroma
