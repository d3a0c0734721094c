// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mappings/frame_mapping.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "framework/mechanics/signs.h"

namespace stroma {

void FrameMapping::declare(DataTable& table) {
  CurvedMapping::declare(table);
  declareGeometricStiffness(table, geometric_, true);
}

void FrameMapping::start() {
  if (!input().hasFrames())
    throw ComponentError(input().path() + " has no frames", "a state of template Rigid3");
  start_ = {0};
  carried_.clear();
  turns_.clear();
  turned_.clear();
  pulled_.clear();
}

void FrameMapping::addPoint(const std::vector<Carried>& by) {
  carried_.insert(carried_.end(), by.begin(), by.end());
  start_.push_back(carried_.size());
}

void FrameMapping::addFrame(Index frame, const Vec3& local, const Quaternion& turn) {
  addPoint({{frame, 1, local}});
  start_.push_back(carried_.size());
  turns_.emplace_back(frame, turn);
}

Vec3 FrameMapping::centre(Index frame, bool at_rest) const { return rowsOfInput(at_rest)[std::size_t(2 * frame)]; }

Quaternion FrameMapping::orientation(Index frame, bool at_rest) const {
  return turnedBy(rowsOfInput(at_rest)[std::size_t(2 * frame + 1)]);
}

void FrameMapping::placeChild(bool at_rest) {
  State& child = output();
  for (const bool rest : {false, true}) {
    if (rest && !at_rest) continue;
    std::vector<Vec3>& rows = rest ? child.rest_position : child.position;
    std::size_t turn = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (child.kindOf(Index(i)) == RowKind::turn) {
        rows[i] = signedRotationVector(orientation(turns_[turn].first, rest) * turns_[turn].second), ++turn;
        continue;
      }
      rows[i].setZero();
      for (std::size_t k = start_[i]; k < start_[i + 1]; ++k)
        rows[i] += carried_[k].weight *
                   (centre(carried_[k].frame, rest) + orientation(carried_[k].frame, rest) * carried_[k].local);
    }
  }
}

/// q p as Eigen has it, to the last bit: a tool turns more than once in a step, and has many points.
static Vec3 turnedArm(const double* q, const Vec3& p) {
  const Vec3 axis(q[0], q[1], q[2]), once = axis.cross(p), twice = once + once;
  return p + q[3] * twice + axis.cross(twice);
}

/// Arms stay as long as no frame turns: a tool that is held or moved along is asked for many times in a step.
void FrameMapping::placeArms(ConstRows x) const {
  const std::size_t frames = std::size_t(input().size()) / 2;
  bool stay = turned_.size() == frames * row_doubles && arms_.size() == carried_.size();
  turned_.resize(frames * row_doubles), arms_.resize(carried_.size());
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const double* row = x.data + std::size_t(parentRow(Index(frame)) + 1) * row_doubles;
    double* known = turned_.data() + frame * row_doubles;
    stay = stay && std::equal(row, row + row_doubles, known);
    std::copy(row, row + row_doubles, known);
  }
  if (stay) return;
  pulled_.clear();
  for (std::size_t k = 0; k < carried_.size(); ++k)
    arms_[k] = turnedArm(turned_.data() + std::size_t(carried_[k].frame) * row_doubles, carried_[k].local);
}

void FrameMapping::apply(Rows x) const {
  const State& child = output();
  const Index first = child.firstRow(), parent = input().firstRow();
  placeArms(x);
  std::size_t turn = 0;
  for (std::size_t i = 0; i + 1 < start_.size(); ++i) {
    const Index row = first + Index(i);
    if (!turns_.empty() && child.kindOf(Index(i)) == RowKind::turn) {
      const auto& [frame, local] = turns_[turn++];
      putOrientation(orientationIn(x, parent + 2 * frame + 1) * local, x, row);
      continue;
    }
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) {
      const Carried& by = carried_[k];
      sum += by.weight * (x[parent + 2 * by.frame] + arms_[k]);
    }
    x[row] = sum;
  }
}

void FrameMapping::applyJ(Rows v) const {
  const State& child = output();
  const Index first = child.firstRow(), parent = input().firstRow();
  std::size_t turn = 0;
  for (std::size_t i = 0; i + 1 < start_.size(); ++i) {
    Vec3 sum = Vec3::Zero();
    if (!turns_.empty() && child.kindOf(Index(i)) == RowKind::turn) sum = v[parent + 2 * turns_[turn++].first + 1];
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) {
      const Index row = parent + 2 * carried_[k].frame;
      sum += carried_[k].weight * (v[row] + v[row + 1].cross(arms_[k]));
    }
    v[first + Index(i)] = sum;
  }
}

void FrameMapping::applyJT(Rows f) const {
  const State& child = output();
  const Index first = child.firstRow(), parent = input().firstRow();
  std::size_t turn = 0;
  for (std::size_t i = 0; i + 1 < start_.size(); ++i) {
    const Vec3 force = f[first + Index(i)];
    if (!turns_.empty() && child.kindOf(Index(i)) == RowKind::turn) f[parent + 2 * turns_[turn++].first + 1] += force;
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) {
      const Index row = parent + 2 * carried_[k].frame;
      f[row] += carried_[k].weight * force;
      f[row + 1] += carried_[k].weight * arms_[k].cross(force);
    }
  }
}

void FrameMapping::addJacobian(std::vector<JacobianBlock>& out) const {
  const Index first = output().firstRow();
  std::size_t turn = 0;
  for (std::size_t i = 0; i + 1 < start_.size(); ++i) {
    const Index own = first + Index(i);
    if (output().kindOf(Index(i)) == RowKind::turn)
      out.push_back({own, parentRow(turns_[turn++].first) + 1, Mat3::Identity()});
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) {
      const Index row = parentRow(carried_[k].frame);
      const double w = carried_[k].weight;
      out.push_back({own, row, w * Mat3::Identity()});
      out.push_back({own, row + 1, -w * crossMatrix(arms_[k])});
    }
  }
}

void FrameMapping::addCurvature(ConstRows v, Rows a) const {
  if (!convects()) return;
  const Index first = output().firstRow();
  for (std::size_t i = 0; i + 1 < start_.size(); ++i)
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) {
      const Vec3 spin = v[parentRow(carried_[k].frame) + 1];
      a[first + Index(i)] += carried_[k].weight * spin.cross(spin.cross(arms_[k]));
    }
}

/// The blocks stay as long as no frame turns and no force changes: conjugate gradients ask many times with both.
void FrameMapping::addGeometricProduct(ConstRows f, ConstRows dx, double factor, Rows df) const {
  const ConstRows own = output().segment(f);
  if (pulled_.size() != own.doubles() || !std::equal(pulled_.begin(), pulled_.end(), own.data)) {
    pulled_.assign(own.data, own.data + own.doubles());
    products_.clear();
    geometricBlocks(f, products_);
  }
  for (const Block& block : products_) df[block.row] += factor * (block.value * dx[block.column]);
}

/// One block for each frame: of its blocks together what draws the frame back.
void FrameMapping::keepWhatResists(std::vector<Block>& blocks) {
  std::sort(blocks.begin(), blocks.end(), [](const Block& a, const Block& b) { return a.row < b.row; });
  std::size_t kept = 0;
  for (const Block& block : blocks) {
    if (kept > 0 && blocks[kept - 1].row == block.row)
      blocks[kept - 1].value += block.value;
    else
      blocks[kept++] = block;
  }
  blocks.resize(kept);
  for (Block& block : blocks) {
    const Eigen::SelfAdjointEigenSolver<Mat3> own(block.value);
    block.value = own.eigenvectors() * own.eigenvalues().cwiseMin(0).asDiagonal() * own.eigenvectors().transpose();
  }
}

void FrameMapping::geometricBlocks(ConstRows f, std::vector<Block>& out) const {
  if (geometric_ == GeometricStiffness::none) return;
  const Index first = output().firstRow();
  for (std::size_t i = 0; i + 1 < start_.size(); ++i)
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) {
      const Index row = parentRow(carried_[k].frame) + 1;
      Block block{row, row, Mat3::Zero()};
      if (f.count > 0) {
        const Vec3 force = carried_[k].weight * f[first + Index(i)], &r = arms_[k];
        block.value = 0.5 * (r * force.transpose() + force * r.transpose()) - r.dot(force) * Mat3::Identity();
      }
      out.push_back(block);
    }
  if (geometric_ == GeometricStiffness::stabilized) keepWhatResists(out);
}

}  // namespace stroma
