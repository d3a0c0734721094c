// SPDX-License-Identifier: LGPL-2.1-or-later
// Bodies of published benchmarks of contact: bricks and shells of spheres, in hexahedra.
#pragma once
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/contact/contact_scenes.h"

namespace stroma::test {

struct HexahedralMesh {
  std::vector<Vec3> points;
  std::vector<std::array<int, 8>> cells;

  /// Nodes of which `is` is true, as an attribute.
  std::string where(const std::function<bool(const Vec3&)>& is) const {
    std::string text;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (is(points[i])) text += fmt::format("{} ", i);
    return text;
  }
  std::string topology() const {
    std::string text = "<MeshTopology name=\"mesh\" position=\"";
    for (const Vec3& p : points) text += fmt::format("{} {} {}  ", p.x(), p.y(), p.z());
    text += "\" hexahedra=\"";
    for (const auto& c : cells) text += fmt::format("{} {} {} {} {} {} {} {}  ", c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]);
    return text + "\"/>";
  }
};

/// From 0 in cells of size h up to `even`, then each `growth` times larger than the one before, up to `end`.
inline std::vector<double> gradedUpTo(double h, double even, double growth, double end) {
  std::vector<double> x{0};
  while (x.back() < end) {
    if (x.back() > even - 0.5 * h) h *= growth;
    const double next = x.back() + h;
    x.push_back(next > end - 0.5 * h ? end : next);
  }
  return x;
}
/// The same numbers below `top`, in ascending order.
inline std::vector<double> downFrom(double top, const std::vector<double>& depths) {
  std::vector<double> z;
  for (auto depth = depths.rbegin(); depth != depths.rend(); ++depth) z.push_back(top - *depth);
  return z;
}
inline std::vector<double> evenly(double from, double to, int cells) {
  std::vector<double> x;
  for (int i = 0; i <= cells; ++i) x.push_back(from + (to - from) * i / cells);
  return x;
}

inline HexahedralMesh brickOf(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z) {
  HexahedralMesh mesh;
  const int n = int(x.size()), m = int(y.size());
  const auto node = [&](std::size_t i, std::size_t j, std::size_t k) { return int(i) + n * (int(j) + m * int(k)); };
  for (std::size_t k = 0; k < z.size(); ++k)
    for (std::size_t j = 0; j < y.size(); ++j)
      for (std::size_t i = 0; i < x.size(); ++i) {
        mesh.points.emplace_back(x[i], y[j], z[k]);
        if (i + 1 < x.size() && j + 1 < y.size() && k + 1 < z.size())
          mesh.cells.push_back({node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k), node(i, j, k + 1),
                                node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)});
      }
  return mesh;
}

/// A part of a side of a cube around the middle of a sphere: the axis of its normal, which way it goes, and angles along the
/// other two axes in their order.
struct SideOfCube {
  int axis, sign;
  std::vector<double> u, v;
};

/// What lies on these sides, drawn to spheres of these radii. Sides that meet must have the same angles there.
inline HexahedralMesh shellOf(const std::vector<SideOfCube>& sides, const std::vector<double>& radii) {
  HexahedralMesh mesh;
  std::map<std::array<long, 3>, int> index;
  const auto node = [&](const Vec3& p) {
    const auto [at, is_new] = index.try_emplace({std::lround(p.x() * 1e9), std::lround(p.y() * 1e9), std::lround(p.z() * 1e9)},
                                                int(mesh.points.size()));
    if (is_new) mesh.points.push_back(p);
    return at->second;
  };
  for (const SideOfCube& side : sides) {
    const auto at = [&](double u, double v, double r) {
      Vec3 p;
      p[side.axis] = side.sign;
      p[side.axis == 0 ? 1 : 0] = std::tan(u);
      p[side.axis == 2 ? 1 : 2] = std::tan(v);
      return node(r * p.normalized());
    };
    // u, v and the outward radius are a right-handed system where this is positive
    const bool turns_right = (side.axis == 1 ? -1 : 1) * side.sign > 0;
    for (std::size_t i = 0; i + 1 < side.u.size(); ++i)
      for (std::size_t j = 0; j + 1 < side.v.size(); ++j)
        for (std::size_t k = 0; k + 1 < radii.size(); ++k) {
          std::array<int, 8> cell{};
          for (std::size_t layer = 0; layer < 2; ++layer) {
            const double r = radii[k + layer];
            const int first = at(side.u[i], side.v[j], r), along_u = at(side.u[i + 1], side.v[j], r),
                      across = at(side.u[i + 1], side.v[j + 1], r), along_v = at(side.u[i], side.v[j + 1], r);
            const std::array<int, 4> face{first, turns_right ? along_u : along_v, across, turns_right ? along_v : along_u};
            for (std::size_t corner = 0; corner < 4; ++corner) cell[4 * layer + corner] = face[corner];
          }
          mesh.cells.push_back(cell);
        }
  }
  return mesh;
}

/// An eighth of a hollow sphere, where x, y and z are positive.
inline HexahedralMesh eighthOfSphere(double inner, double outer, int n, int layers) {
  const std::vector<double> angles = evenly(0, M_PI / 4, n);
  return shellOf({{0, 1, angles, angles}, {1, 1, angles, angles}, {2, 1, angles, angles}}, evenly(inner, outer, layers));
}
/// The half of a hollow sphere below z = 0, with n cells (an even number) along a quarter of its rim.
inline HexahedralMesh halfOfSphere(double inner, double outer, int n, int layers) {
  const std::vector<double> whole = evenly(-M_PI / 4, M_PI / 4, n), low = evenly(-M_PI / 4, 0, n / 2);
  return shellOf({{0, 1, whole, low}, {0, -1, whole, low}, {1, 1, whole, low}, {1, -1, whole, low}, {2, -1, whole, whole}},
                 evenly(inner, outer, layers));
}

/// A node with a state "dofs" and a mesh of a neo-Hookean material.
inline std::string neoHookeanNode(const std::string& name, const HexahedralMesh& mesh, double young, double poisson,
                                  const std::string& more) {
  return fmt::format(
      "<Node name=\"{}\">{}<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1\"/>"
      "<HexahedronHyperelasticityFEMForceField materialName=\"NeoHookean\" youngModulus=\"{}\" poissonRatio=\"{}\"/>{}</Node>",
      name, mesh.topology(), young, poisson, more);
}

/// Of the BarrierContact with this name.
inline std::vector<double> wrenchesOf(Simulation& simulation, const std::string& name) {
  std::vector<double> values;
  for (const auto& system : simulation.systems())
    for (ForceField* field : system->forceFields())
      if (field->name() == name) {
        std::istringstream text(field->data().find("wrenches")->print());
        for (double value = 0; text >> value;) values.push_back(value);
      }
  return values;
}

/// Within what programs have published.
inline void expectWithin(double value, double least, double most, const std::string& what) {
  EXPECT_GE(value, least) << what;
  EXPECT_LE(value, most) << what;
}

}  // namespace stroma::test
