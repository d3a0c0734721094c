// SPDX-License-Identifier: LGPL-2.1-or-later
// Affine matrices, 16 numbers by rows, that are made one after another before the first step: for `transformation` of loaders and
// `matrix` of TransformPosition.
//
// TranslateTransformMatrixEngine: outT = inT M of translation;   M moves points by it.
// RotateTransformMatrixEngine: outT = inT M of rotation;         M turns about x, then y, then z [degree].
// ScaleTransformMatrixEngine: outT = inT M of scale;             M multiplies coordinates by it.
// InvertTransformMatrixEngine: outT = inT^-1.
//
// The matrix of a later engine so acts on points before that of an earlier one. inT is the identity when it is not given.
//
// Source: names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="20" tolerance="1e-9"/>
//   <TranslateTransformMatrixEngine name="lifted" translation="0 2 0"/>
//   <RotateTransformMatrixEngine name="turned" inT="@lifted.outT" rotation="0 0 90"/>
//   <ScaleTransformMatrixEngine name="grown" inT="@turned.outT" scale="2 2 2"/>
//   <InvertTransformMatrixEngine name="back" inT="@lifted.outT"/>
//   <MeshTopology name="net" position="0 0 0  1 0 0  1 1 0" triangles="0 1 2"/>
//   <TransformPosition name="moved" method="affine" matrix="@grown.outT" input_position="@net.position"/>
//   <TransformPosition name="lowered" method="affine" matrix="@back.outT" input_position="@moved.output_position"/>
//   <MechanicalObject position="@lowered.output_position"/>
//   <UniformMass totalMass="1"/>
// </Node>
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "components/selection/engine.h"
#include "framework/mesh/mesh_loader.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// One class serves all four names.
class TransformMatrixEngine final : public Engine {
 public:
  enum class Kind { translation, rotation, scale, inverse } kind = Kind::inverse;  ///< set by the registration of a name

  void declare(DataTable& table) override {
    if (kind == Kind::scale) by_ = Vec3::Ones();
    table.add("inT", in_).help("the matrix before, by rows").unit("-");
    table.add("outT", out_).help("the matrix that is made, by rows").unit("-").output();
    if (kind == Kind::translation) table.add("translation", by_).help("the way").unit("m");
    if (kind == Kind::rotation) table.add("rotation", by_).help("about x, then y, then z").unit("degree");
    if (kind == Kind::scale) table.add("scale", by_).help("factors along the axes").unit("-");
  }
  void init() override {
    const auto in = Eigen::Map<const Matrix>(in_.data());
    auto out = Eigen::Map<Matrix>(out_.data());
    if (kind != Kind::inverse) {
      out = in * own();
      return;
    }
    if (!in.allFinite()) throw ComponentError("inT has a number that is not finite", "16 numbers");
    // a far translation has no part in whether a matrix flattens: it is a length, and depends on the unit of lengths
    const bool is_affine = in.row(3) == Eigen::RowVector4d::Unit(3);
    if (is_affine) {
      out = Matrix::Identity();
      out.topLeftCorner<3, 3>() = inverseOf<Mat3>(in.topLeftCorner<3, 3>());
      out.topRightCorner<3, 1>() = -out.topLeftCorner<3, 3>() * in.topRightCorner<3, 1>();
    } else {
      out = inverseOf<Eigen::Matrix4d>(in);
    }
  }

 private:
  using Matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  template <class Square>
  static Square inverseOf(const Square& in) {
    const Eigen::FullPivLU<Square> factors(in);
    if (!factors.isInvertible()) throw ComponentError("inT has no inverse", "a matrix that flattens nothing");
    return factors.inverse();
  }
  Matrix own() const {
    Matrix own = Matrix::Identity();
    if (kind == Kind::translation) own.topRightCorner<3, 1>() = by_;
    if (kind == Kind::rotation) own.topLeftCorner<3, 3>() = rotationFromDegrees(by_);
    if (kind == Kind::scale) own.diagonal().head<3>() = by_;
    return own;
  }
  std::array<double, 16> in_{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, out_ = in_;
  Vec3 by_ = Vec3::Zero();
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(matrix_engines) {
  using Engine = stroma::TransformMatrixEngine;
  factory.add<Engine>("TranslateTransformMatrixEngine", "an affine matrix that moves points",
                      [](Engine& e) { e.kind = Engine::Kind::translation; });
  factory.add<Engine>("RotateTransformMatrixEngine", "an affine matrix that turns points",
                      [](Engine& e) { e.kind = Engine::Kind::rotation; });
  factory.add<Engine>("ScaleTransformMatrixEngine", "an affine matrix that multiplies coordinates",
                      [](Engine& e) { e.kind = Engine::Kind::scale; });
  factory.add<Engine>("InvertTransformMatrixEngine", "the inverse of an affine matrix",
                      [](Engine& e) { e.kind = Engine::Kind::inverse; });
}
