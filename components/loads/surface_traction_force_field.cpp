// SPDX-License-Identifier: LGPL-2.1-or-later
// SurfaceTractionForceField: a force per area of a given direction on triangles and quads.
//
//   f_a = t integral of N_a dA
//
// area = current: dA is the area of the deformed surface, so that t is the Cauchy traction: a face stretched to twice its area
// carries twice the force. There is no potential. area = rest: dA is that of the rest shape, a dead load with E = -sum f_a .
// x_a. In both t keeps its direction when the surface rotates; for a pressure, which rotates with it, use
// SurfacePressureForceField. The integral is exact for triangles; for quads it has 2 x 2 Gauss points.
//
//   df_a = t integral of N_a n . (dg_1 x g_2 + g_1 x dg_2),   g_1, g_2 the tangents of the surface, n its normal
//
// is the tangent of the first, which is not symmetric: tangent = exact wants a solver for such matrices (EigenSparseLU).
// symmetric takes the symmetric part, which is approximate: Newton's method needs more iterations and finds the same
// equilibrium.
//
// The traction is constant, or keyTractions at keyTimes and linear between them. Loaded are the listed faces; without lists
// those of the surface in the box from min to max at rest, as in SurfacePressureForceField.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology position="0 0 0  1 0 0  1 1 0.1  0 1 0  2 0 0  2 1 0.2" edges="0 1  1 2  2 3  3 0  0 2  1 4  4 5
//       5 2  2 4" quads="0 1 2 3" triangles="1 4 5  1 5 2"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 3"/>
//   <MeshSpringForceField linesStiffness="200"/>
//   <SurfaceTractionForceField traction="20 0 5" tangent="exact"/>
// </Node>
#include <cmath>

#include "components/loads/surface_load.h"
#include "framework/mechanics/key_times.h"
#include "framework/mechanics/surface_selection.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// A point of a face: shape functions, their slopes along the tangents, and n dA with its weight.
struct SurfacePoint {
  double n[most_face_nodes];
  LocalPoint slopes[most_face_nodes];
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();  ///< g_1, g_2 [m]
  double weight;
  SurfacePoint(const CellKind& kind, const QuadraturePoint& point, const area_vectors::Corners& x)
      : weight(point.weight) {
    kind.shapes(point.xi, n);
    kind.gradients(point.xi, slopes);
    for (std::size_t a = 0; a < std::size_t(kind.nodes); ++a)
      first += slopes[a][0] * x[a], second += slopes[a][1] * x[a];
  }
};

template <class Visit>
void forEachPoint(const area_vectors::Corners& x, const CellKind& kind, Visit&& visit) {
  const int degree = kind.affine ? 1 : 4;  // of a triangle one point has the integral of N_a
  for (const QuadraturePoint& point : kind.rule(degree).points) visit(SurfacePoint(kind, point, x));
}

/// Integral of N_a dA [m^2] for each corner.
std::array<double, most_face_nodes> shares(const area_vectors::Corners& x, const CellKind& kind) {
  std::array<double, most_face_nodes> out{};
  forEachPoint(x, kind, [&](const SurfacePoint& p) {
    const double area = p.weight * p.first.cross(p.second).norm();
    for (std::size_t a = 0; a < std::size_t(kind.nodes); ++a) out[a] += p.n[a] * area;
  });
  return out;
}

class SurfaceTractionForceField final : public NodeGroupField<face_nodes, FaceTangent>, public LocalLoad {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "surface");
    table.add("traction", traction_).recompiled().help("force per area").unit("Pa");
    table.add("keyTimes", key_times_).help("times, ascending; outside of them the traction is constant").unit("s");
    table.add("keyTractions", key_tractions_).help("traction at each of keyTimes, instead of traction").unit("Pa");
    table.addChoice("area", area_, {"current", "rest"}).help("the area that carries the traction");
    selection_.declare(table);
    table.addChoice("tangent", tangent_, {"symmetric", "exact"})
        .help(
            "symmetric part of the stiffness, approximate, for any solver; or the exact one, for unsymmetric solvers");
  }

  void init() override {
    ForceField::init();
    checkTraction();
    const Topology* topology = topology_.find(*this, state());
    if (!topology) throw ComponentError("no mesh in this node or above", "a topology with triangles or quads");
    faces_ = selection_.faces(*this, topology->mesh(), state());
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    const bool dead = area_ == Area::rest, exact = tangent_ == TangentWord::exact;
    traits.linear = traits.constant_stiffness = traits.conservative = dead;
    traits.has_stiffness = !dead;
    traits.symmetric = dead || !exact;
    traits.exact_tangent = dead || exact;
    traits.time_dependent = !key_times_.empty();
    return traits;
  }
  void setTime(double t) override {
    if (!key_times_.empty()) now_ = keys_.at(t);
  }

  void compile() override {
    std::vector<Group> rows;
    rest_shares_.clear();
    for (const Face& face : faces_) {
      rows.push_back(face.nodes);
      area_vectors::Corners at;
      for (std::size_t a = 0; a < at.size(); ++a) at[a] = state().rest_position[face.nodes[a]];
      for (Index& row : rows.back()) row += state().firstRow();
      rest_shares_.push_back(shares(at, face.kind()));
    }
    setGroups(std::move(rows), false);
    for (std::size_t i = 0; i < faces_.size(); ++i) stiffness_[i].corners = faces_[i].corners;
    corners_.resize(faces_.size());
  }

  double energy(ConstRows x) const override {
    if (area_ != Area::rest) return 0;
    double sum = 0;
    for (std::size_t i = 0; i < faces_.size(); ++i)
      for (std::size_t a = 0; a < most_face_nodes; ++a) sum -= rest_shares_[i][a] * now_.dot(x[rows_[i][a]]);
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      for (std::size_t a = 0; a < most_face_nodes; ++a) corners_[i][a] = x[rows_[i][a]];
      const std::array<double, most_face_nodes> areas =
          area_ == Area::rest ? rest_shares_[i] : shares(corners_[i], faces_[i].kind());
      for (std::size_t a = 0; a < std::size_t(faces_[i].corners); ++a) f[rows_[i][a]] += areas[a] * now_;
    }
    if (area_ == Area::current) outdateTangents();
  }
  void addLoadedRows(std::vector<Index>& rows) const override {
    for (const Face& face : faces_)
      for (int a = 0; a < face.corners; ++a) rows.push_back(state().firstRow() + face.nodes[a]);
  }

 protected:
  void computeTangents() const override {
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      const std::size_t corners = std::size_t(faces_[i].corners);
      FaceTangent exact;
      exact.setZero();
      forEachPoint(corners_[i], faces_[i].kind(), [&](const SurfacePoint& p) {
        const Vec3 area = p.first.cross(p.second);
        if (!(area.norm() > 0)) return;  // a point without an area has no normal
        const Vec3 n = area.normalized(), along_first = p.second.cross(n), along_second = n.cross(p.first);
        for (std::size_t b = 0; b < corners; ++b) {
          const Vec3 slope = p.weight * (p.slopes[b][0] * along_first + p.slopes[b][1] * along_second);
          for (std::size_t a = 0; a < corners; ++a) exact.block(int(a), int(b)) += p.n[a] * now_ * slope.transpose();
        }
      });
      for (int a = 0; a < int(corners); ++a)
        for (int b = 0; b < int(corners); ++b)
          stiffness_[i].block(a, b) = tangent_ == TangentWord::exact
                                          ? exact.block(a, b)
                                          : Mat3((exact.block(a, b) + exact.block(b, a).transpose()) / 2);
    }
  }

 private:
  enum class Area : int { current, rest };
  enum class TangentWord : int { symmetric, exact };

  void checkTraction() {
    const bool given = data().find("traction")->isSet();
    if (key_times_.empty() != key_tractions_.empty())
      throw ComponentError("keyTimes and keyTractions are not given together", "both or none of them");
    if (!key_times_.empty()) {
      if (given) throw ComponentError("traction and keyTractions are both given", "one of them");
      keys_.assign(key_times_, key_tractions_, "keyTimes", "keyTractions");
      keys_.check();
      now_ = keys_.at(node().root().root_time);
      return;
    }
    if (!given) throw ComponentError("there is no traction", "traction, or keyTimes and keyTractions");
    if (!traction_.allFinite()) throw ComponentError("the traction is not finite", "finite numbers");
    now_ = traction_;
  }

  TopologyLink topology_;
  SurfaceSelection selection_;
  Vec3 traction_ = Vec3::Zero();
  std::vector<double> key_times_;
  std::vector<Vec3> key_tractions_;
  KeyTimes<Vec3> keys_;
  Area area_ = Area::current;
  TangentWord tangent_ = TangentWord::symmetric;

  std::vector<Face> faces_;
  std::vector<std::array<double, most_face_nodes>> rest_shares_;  ///< integral of N_a dA at rest [m^2], shape (faces)
  std::vector<area_vectors::Corners> corners_;                    ///< positions of the last force [m], shape (faces)
  Vec3 now_ = Vec3::Zero();                                       ///< t [Pa]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(surface_traction_force_field) {
  factory.add<stroma::SurfaceTractionForceField>("SurfaceTractionForceField",
                                                 "a force per current area, or per area at rest, of a fixed direction");
}
