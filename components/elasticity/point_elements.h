// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <limits>

#include "components/elasticity/elastic_elements.h"

namespace stroma {

/// Cells with several integration points. `Own` has, for a cell and positions that start at node 0,
///   forEachStrain(cell, x, use(strain, carrier, volume))   as ElasticElements::forEachPoint()
///   forEachJacobian(cell, x, use(J))
template <class Own>
class PointElements : public ElasticElements {
 public:
  bool has(ElasticMethod method) const override { return method != ElasticMethod::nodal; }
  bool hasMeanDilatation(ElasticMethod) const override { return true; }
  void bind(const Mesh& mesh, const std::vector<Vec3>& rest, const ElasticVariant& variant) override {
    variant_ = variant;
    own().bindShapes(mesh, rest);
  }

  double jacobian(std::size_t cell, ConstRows x) const override {
    double least = std::numeric_limits<double>::infinity();
    own().forEachJacobian(cell, x, [&least](double j) {
      if (!(j >= least) && least == least) least = j;  // a NaN stays
    });
    return least;
  }
  Mat3 strain(std::size_t cell, ConstRows x) const override {
    Mat3 sum = Mat3::Zero();
    double volume = 0;
    own().forEachStrain(cell, x, [&](const Mat3& here, const Mat3&, double weight) {
      sum += weight * here;
      volume += weight;
    });
    return sum / volume;
  }
  void forEachPoint(std::size_t cell, ConstRows x, const UseOfPoint& use) const override {
    own().forEachStrain(cell, x, use);
  }
  double strainBeyond(double limit, std::size_t cell, ConstRows x) const override {
    double worst = 0;
    own().forEachStrain(cell, x, [&](const Mat3& here, const Mat3&, double) {
      worst = std::max(worst, principalBeyond(limit, here, variant_.method == ElasticMethod::green));
    });
    return worst;
  }

 protected:
  ElasticVariant variant_;

 private:
  Own& own() { return static_cast<Own&>(*this); }
  const Own& own() const { return static_cast<const Own&>(*this); }
};

}  // namespace stroma
