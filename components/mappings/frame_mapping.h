// SPDX-License-Identifier: LGPL-2.1-or-later
// Points and frames that are carried by rigid frames. A point is a weighted sum over frames (centre c, orientation q) of a
// point p that is fixed in each,
//
//   x = sum w (c + q p),   v = sum w (c' + omega x r),   r = q p
//   force on the centre += w f,   torque += w r x f;   x'' has sum w omega x (omega x r) besides J times accelerations
//
// and its geometric stiffness, the change of the torque with the turn, is w (1/2 (r f^T + f r^T) - (r.f) I); stabilized, the
// part of a frame's sum of these whose eigenvalues are not positive. A frame is carried by one: its centre as such a point, its
// orientation is q l with l fixed.
#pragma once
#include "components/mappings/linked_mapping.h"
#include "framework/mechanics/frames.h"

namespace stroma {

class FrameMapping : public CurvedMapping {
 public:
  void declare(DataTable& table) override;  ///< geometricStiffness besides
  void apply(Rows x) const override;
  void applyJ(Rows v) const override;
  void applyJT(Rows f) const override;
  void addJacobian(std::vector<JacobianBlock>& out) const override;
  void addCurvature(ConstRows v, Rows a) const override;
  void addGeometricProduct(ConstRows f, ConstRows dx, double factor, Rows df) const override;

 protected:
  /// Throws ComponentError unless the state that is followed has frames; forgets all points.
  void start();
  /// The next rows of output(): a point, carried by frames of input() (counted as nodes).
  struct Carried {
    Index frame = 0;
    double weight = 1;
    Vec3 local = Vec3::Zero();  ///< p [m]
  };
  void addPoint(const std::vector<Carried>& by);
  void addFrame(Index frame, const Vec3& local, const Quaternion& turn);
  /// Where a frame starts, or rests.
  Vec3 centre(Index frame, bool at_rest = false) const;
  Quaternion orientation(Index frame, bool at_rest = false) const;
  /// At the end of init(): the child starts where the frames have it; also at rest, when `at_rest`.
  void placeChild(bool at_rest);

  void geometricBlocks(ConstRows f, std::vector<Block>& out) const override;

 private:
  const std::vector<Vec3>& rowsOfInput(bool at_rest) const {
    return at_rest ? input().rest_position : input().position;
  }
  Index parentRow(Index frame) const { return input().firstRow() + 2 * frame; }
  void placeArms(ConstRows x) const;
  static void keepWhatResists(std::vector<Block>& blocks);

  std::vector<std::size_t> start_;  ///< of each child row's terms in carried_; of an orientation there are none
  std::vector<Carried> carried_;
  std::vector<std::pair<Index, Quaternion>> turns_;  ///< of each child row that is an orientation: frame and l
  mutable std::vector<Vec3> arms_;                   ///< r of carried_ at the last apply()
  mutable std::vector<double> turned_;               ///< rows of orientations there, which arms_ follow from
  mutable std::vector<double> pulled_;               ///< rows of forces on output() that products_ follow from, or empty
  mutable std::vector<Block> products_;              ///< geometricBlocks() there: of all products with one matrix
  GeometricStiffness geometric_ = GeometricStiffness::exact;
};

}  // namespace stroma
