// SPDX-License-Identifier: LGPL-2.1-or-later
// Regression of rigid frames and numbers: each kind is judged by its own size, and orientations by their angle.
#include <fmt/format.h>

#include "framework/mechanics/frames.h"
#include "framework/simulation/state_file.h"
#include "tests/support/shell.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A mechanism of 1 cm: three frames, of which the first spins.
struct Mechanism {
  Vec3 tip = Vec3(0.01, 0, 0), spin = Vec3(3, -14, 8);
  Quaternion first = Quaternion(-0.8, 0, 0, -0.6), second = Quaternion::Identity();
  double number = 0.002;
};

class RegressFrames : public CommandTest {
 protected:
  void scene(const Mechanism& m) const {
    const auto frame = [](const Vec3& at, const Quaternion& q) {
      return fmt::format("{} {} {} {} {} {} {} ", at.x(), at.y(), at.z(), q.x(), q.y(), q.z(), q.w());
    };
    write("frames.xml",
          "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><EulerExplicitSolver/><Node name=\"body\"><MechanicalObject name=\"dofs\" "
          "template=\"Rigid3\" position=\"" + frame(Vec3::Zero(), m.first) + frame(m.tip, m.second) +
              frame(Vec3(0, 0.005, 0), Quaternion::Identity()) +
              fmt::format("\" velocity=\"0.001 0 0 {} {} {}  0 0 0 0 0 0  0 0 0 0 0 0\"/>", m.spin.x(), m.spin.y(), m.spin.z()) +
              "<UniformMass totalMass=\"3\" inertia=\"0.1 0.1 0.1\"/></Node><Node name=\"slider\"><MechanicalObject name=\"dofs\" "
              "template=\"Vec2\" position=\"0.001 " + fmt::format("{}", m.number) +
              "\"/><UniformMass totalMass=\"1\"/></Node></Node>");
  }
  void SetUp() override {
    CommandTest::SetUp();
    scene({});
    write("list", "references\nframes.xml 40 1e-6\n");
    ASSERT_EQ(stroma("regress list --update").code, 0);
  }
  std::string reference() const { return (folder_ / "references/frames/body.dofs.state.gz").string(); }
  void passes(const Mechanism& m) const {
    scene(m);
    const Finished run = stroma("regress list");
    EXPECT_EQ(run.code, 0) << run.out << run.err;
  }
  /// A reference of an older scene, with the same nodes and times.
  void isStale(const Mechanism& m, const std::string& sentence) const {
    scene(m);
    const Finished run = stroma("regress list");
    EXPECT_EQ(run.code, 1) << run.out << run.err;
    EXPECT_NE(run.out.find(sentence), std::string::npos) << run.out;
  }
};

TEST_F(RegressFrames, EachKindIsJudgedByItsOwnSize) {
  passes({});
  passes({.tip = Vec3(0.01 + 5e-9, 0, 0)});
  isStale({.tip = Vec3(0.01 + 1e-7, 0, 0)}, "position differs by 1.03e-05 (tolerance 1e-06) at t = 0 s, most at node 1");
  passes({.second = turnedBy(Vec3(0, 3e-7, 0))});
  isStale({.second = turnedBy(Vec3(0, 1e-5, 0))},
          "orientation (rotation vector) differs by 1e-05 (tolerance 1e-06) at t = 0 s, most at node 1");
  isStale({.spin = 1.01 * Vec3(3, -14, 8)}, "angular velocity differs by 0.01");
  passes({.number = 0.002 + 5e-10});
  isStale({.number = 0.002 + 1e-8}, "number differs by 1e-05 (tolerance 1e-06) at t = 0 s, most at node 0");
}

TEST_F(RegressFrames, BothQuaternionsOfAnOrientationAreOne) {
  passes({.first = Quaternion(0.8, 0, 0, 0.6)});
  const Vec3 half_turn(0, 0, std::acos(-1.));
  scene({.second = turnedBy((1 + 1e-9) * half_turn)});
  ASSERT_EQ(stroma("regress list --update").code, 0);
  passes({.second = turnedBy((1 - 1e-9) * half_turn)});
  passes({.second = turnedBy(-half_turn)});
  isStale({.second = turnedBy((1 - 1e-5) * half_turn)}, "orientation (rotation vector) differs by 3.14");
}

/// 21 and 18 numbers of three frames are seven and six points to a writer of points.
TEST_F(RegressFrames, DamagedReferencesFail) {
  const auto good = readStateFile(reference(), nullptr);
  const auto tampered = [&](const auto& change, const std::string& sentence) {
    auto frames = good;
    for (StateFrame& frame : frames) change(frame);
    StateWriter writer(reference());
    for (const StateFrame& frame : frames) {
      writer.time(frame.time);
      writer.rows("X", frame.x), writer.rows("V", frame.v);
    }
    writer.close();
    const Finished run = stroma("regress list");
    EXPECT_EQ(run.code, sentence.empty() ? 0 : 1) << run.out << run.err;
    EXPECT_NE(run.out.find(sentence), std::string::npos) << run.out;
  };
  tampered([](StateFrame&) {}, "");
  const auto number = [](StateFrame& frame, std::size_t i) -> double& { return frame.x[i / 3][Index(i % 3)]; };
  tampered([&](StateFrame& frame) { for (std::size_t i = 3; i < 7; ++i) number(frame, i) *= -1; }, "");
  tampered([&](StateFrame& frame) { number(frame, 0) = std::nan(""); }, "node 0 at t = 0 s is not finite");
  tampered([&](StateFrame& frame) { number(frame, 4) = std::nan(""); }, "is no orientation");
  tampered([&](StateFrame& frame) { for (std::size_t i = 0; i < 3; ++i) frame.v[i].swap(frame.v[i + 2]); }, "elocity differs");
  tampered([&](StateFrame& frame) { for (std::size_t i = 0; i < 7; ++i) std::swap(number(frame, i), number(frame, i + 7)); },
           "differs");
  tampered([&](StateFrame& frame) { std::swap(number(frame, 3), number(frame, 6)); }, "orientation (rotation vector) differs");
  tampered([&](StateFrame& frame) { frame.time += 1e-3; }, "is at t = ");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
