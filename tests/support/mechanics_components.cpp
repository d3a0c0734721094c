// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/mechanics_components.h"

#include <Eigen/Geometry>

#include "framework/mesh/topology.h"
#include "framework/simulation/simulation.h"

namespace stroma::test {
namespace {

/// Does nothing in a step; a test calls the system itself.
class TestIntegrator final : public Integrator {
 public:
  void declare(DataTable& table) override { declareLinearSolver(table, false); }
  void compile(System&) override {}
  StepReport step(System&, const StepContext&) override { return {}; }
  std::string describe() const override { return "nothing"; }
};

class TestSolver final : public LinearSolver {
 public:
  void declare(DataTable&) override {}
  SolveReport solve(SystemMatrix&, ConstRows, Rows, const SolveTerms&) override { return {}; }
  bool needsSymmetric() const override { return true; }
};

/// A box of n cells per axis; each cell a hexahedron, or six tetrahedra around a diagonal.
class TestMesh final : public Topology {
 public:
  void declare(DataTable& table) override {
    table.add("cells", cells_).help("cells per axis");
    table.add("size", size_).help("lengths of the sides");
    table.add("tetrahedra", tetrahedra_).help("cut cells in six");
    table.add("faces", faces_).help("only the two triangles of each bottom face");
    table.add("extraNodes", extra_).help("nodes without cells, at the end");
    table.add("flip", flip_).help("turn the first tetrahedron inside out");
    table.add("overlap", mesh_.overlap).help("how often the cells cover the body");
    table.add("position", mesh_.position).help("nodes").output();
  }
  void init() override {
    const int n[3] = {cells_[0] + 1, cells_[1] + 1, cells_[2] + 1};
    const auto node = [&n](int i, int j, int k) { return Index(i + n[0] * (j + n[1] * k)); };
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i)
          mesh_.position.push_back(
              size_.cwiseProduct(Vec3(double(i) / cells_[0], double(j) / cells_[1], double(k) / cells_[2])));
    for (int k = 0; k < cells_[2]; ++k)
      for (int j = 0; j < cells_[1]; ++j)
        for (int i = 0; i < cells_[0]; ++i)
          addCell({node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k), node(i, j, k + 1),
                   node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)});
    for (int i = 0; i < extra_; ++i) mesh_.position.push_back(Vec3(9, 9, i));
    if (flip_) std::swap(mesh_.tetrahedra[0][0], mesh_.tetrahedra[0][1]);
  }

 private:
  void addCell(const Hexahedron& c) {
    if (faces_) {
      mesh_.triangles.push_back({c[0], c[1], c[2]});
      mesh_.triangles.push_back({c[0], c[2], c[3]});
    } else if (tetrahedra_) {
      const int ring[7] = {1, 2, 3, 7, 4, 5, 1};
      for (int i = 0; i < 6; ++i) mesh_.tetrahedra.push_back({c[0], c[ring[i]], c[ring[i + 1]], c[6]});
    } else {
      mesh_.hexahedra.push_back(c);
    }
  }
  std::array<int, 3> cells_{1, 1, 1};
  Vec3 size_ = Vec3::Ones();
  bool tetrahedra_ = false, faces_ = false, flip_ = false;
  int extra_ = 0;
};

/// Pairs of nodes i, i + 1 and i, i + 2: what the two nets below share.
class Net : public ForceField {
 public:
  mutable long assemblies = 0;

  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("stiffness", stiffness_).help("of each pair");
    table.add("productCost", cost_.product).help("told to the plan");
    table.add("assemblyCost", cost_.assembly).help("told to the plan");
  }
  void init() override {
    ForceField::init();
    for (int reach = 1; reach <= 2; ++reach)
      for (Index i = 0; i + reach < state().size(); ++i) pairs_.push_back({i, i + reach});
    tangents_.assign(pairs_.size(), -stiffness_ * Mat3::Identity());
  }
  Cost cost() const override { return cost_; }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    forEach([&](std::size_t p, Index a, Index b) {
      const Vec3 force = factor * (tangents_[p] * (dx[b] - dx[a]));
      df[b] += force;
      df[a] -= force;
    });
  }
  void addPattern(BlockPattern& pattern) const override {
    forEach([&](std::size_t, Index a, Index b) {
      const Index rows[2] = {a, b};
      pattern.addClique(rows, 2);
    });
  }
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    ++assemblies;
    forEach([&](std::size_t p, Index a, Index b) {
      matrix.add(a, a, factor * tangents_[p]);
      matrix.add(b, b, factor * tangents_[p]);
      matrix.add(a, b, -factor * tangents_[p]);
      matrix.add(b, a, -factor * tangents_[p]);
    });
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    forEach([&](std::size_t p, Index a, Index b) {
      for (Index row : {a, b})
        for (int c = 0; c < 9; ++c)
          blocks[std::size_t(row) * 9 + std::size_t(c)] += factor * tangents_[p](c / 3, c % 3);
    });
  }

 protected:
  template <class Visit>
  void forEach(Visit visit) const {
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      visit(p, state().firstRow() + pairs_[p][0], state().firstRow() + pairs_[p][1]);
  }
  Vec3 rest(std::size_t p) const { return state().rest_position[pairs_[p][1]] - state().rest_position[pairs_[p][0]]; }
  double stiffness_ = 100;
  std::vector<Edge> pairs_;
  std::vector<Mat3> tangents_;  ///< derivative of the force on b by x_b

 private:
  Cost cost_;
};

/// Energy k/2 |(x_b - x_a) - (X_b - X_a)|^2: linear.
class TestLinearNet final : public Net {
 public:
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.linear = traits.constant_stiffness = true;
    return traits;
  }
  double energy(ConstRows x) const override {
    double sum = 0;
    forEach([&](std::size_t p, Index a, Index b) { sum += 0.5 * stiffness_ * (x[b] - x[a] - rest(p)).squaredNorm(); });
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    forEach([&](std::size_t p, Index a, Index b) {
      const Vec3 force = -stiffness_ * (x[b] - x[a] - rest(p));
      f[b] += force;
      f[a] -= force;
    });
  }
};

/// Energy k/2 (|x_b - x_a| - |X_b - X_a|)^2: the tangent turns with the spring.
class TestSprings final : public Net {
 public:
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = traits.exact_tangent = true;
    return traits;
  }
  double energy(ConstRows x) const override {
    double sum = 0;
    forEach([&](std::size_t p, Index a, Index b) {
      sum += 0.5 * stiffness_ * std::pow((x[b] - x[a]).norm() - rest(p).norm(), 2);
    });
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    forEach([&](std::size_t p, Index a, Index b) {
      const Vec3 d = x[b] - x[a];
      const double length = d.norm(), strain = 1 - rest(p).norm() / length;
      const Vec3 unit = d / length;
      f[b] -= stiffness_ * strain * d;
      f[a] += stiffness_ * strain * d;
      tangents_[p] = -stiffness_ * (strain * Mat3::Identity() + (1 - strain) * unit * unit.transpose());
    });
  }
  std::string worstElement(ConstRows) const override { return "spring 0 of " + std::to_string(pairs_.size()); }
};

/// f_i = k e x (x_i - X_i): a curl, with an antisymmetric stiffness.
class TestUnsymmetric final : public ForceField {
 public:
  void declare(DataTable& table) override { ForceField::declare(table); }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.exact_tangent = true;
    return traits;
  }
  double energy(ConstRows) const override { return 0; }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (Index i = 0; i < state().size(); ++i)
      f[state().firstRow() + i] += turn() * (x[state().firstRow() + i] - state().rest_position[i]);
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override {
    for (Index i = state().firstRow(); i < state().firstRow() + state().size(); ++i) df[i] += factor * turn() * dx[i];
  }
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    for (Index i = state().firstRow(); i < state().firstRow() + state().size(); ++i) matrix.add(i, i, factor * turn());
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    for (Index i = state().firstRow(); i < state().firstRow() + state().size(); ++i)
      for (int c = 0; c < 9; ++c) blocks[std::size_t(i) * 9 + std::size_t(c)] += factor * turn()(c / 3, c % 3);
  }

 private:
  static Mat3 turn() {
    Mat3 m;
    m << 0, -30, 20, 30, 0, -10, -20, 10, 0;
    return m;
  }
};

/// f = -(3 + 2 |v|) v at each node: linear and quadratic drag.
class TestDrag final : public ForceField {
 public:
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.has_stiffness = false;
    traits.symmetric = traits.velocity_dependent = traits.exact_tangent = true;
    return traits;
  }
  double energy(ConstRows) const override { return 0; }
  void addForce(ConstRows, ConstRows v, Rows f) override {
    blocks_.resize(state().size());
    for (Index i = 0; i < state().size(); ++i) {
      const Vec3 u = v[row(i)];
      const double speed = u.norm();
      f[row(i)] -= (3 + 2 * speed) * u;
      blocks_[i] = -(3 + 2 * speed) * Mat3::Identity();
      if (speed > 0) blocks_[i] -= 2 / speed * u * u.transpose();
    }
  }
  void addStiffnessProduct(ConstRows, double, Rows) const override {}
  void addPattern(BlockPattern&) const override {}
  void addStiffness(double, BlockMatrix&) const override {}
  void addStiffnessDiagonal(double, std::vector<double>&) const override {}
  void addDampingProduct(ConstRows dv, double factor, Rows df) const override {
    for (Index i = 0; i < state().size(); ++i) df[row(i)] += factor * (blocks_[i] * dv[row(i)]);
  }
  void addDamping(double factor, BlockMatrix& matrix) const override {
    for (Index i = 0; i < state().size(); ++i) matrix.add(row(i), row(i), factor * blocks_[i]);
  }
  void addDampingDiagonal(double factor, std::vector<double>& blocks) const override {
    for (Index i = 0; i < state().size(); ++i)
      for (int k = 0; k < 9; ++k) blocks[9 * std::size_t(row(i)) + std::size_t(k)] += factor * blocks_[i](k / 3, k % 3);
  }

 private:
  Index row(Index i) const { return state().firstRow() + i; }
  std::vector<Mat3> blocks_;
};

/// Lets nodes slide in the plane with the normal 1 2 3.
class TestPlane : public ProjectiveConstraint {
 public:
  void declare(DataTable& table) override {
    ProjectiveConstraint::declare(table);
    table.add("indices", indices_).help("nodes");
  }
  bool isConstant() const override { return true; }
  void addProjectors(double t, std::vector<NodeProjector>& out) const override {
    const Vec3 n = normal(t);
    for (int i : indices_) out.push_back({state().firstRow() + i, Mat3::Identity() - n * n.transpose()});
  }

 protected:
  virtual Vec3 normal(double) const { return Vec3(1, 2, 3).normalized(); }

 private:
  std::vector<int> indices_;
};

/// The normal turns about z with time, from x.
class TestTurningPlane final : public TestPlane {
 public:
  bool isConstant() const override { return false; }

 protected:
  Vec3 normal(double t) const override { return Vec3(std::cos(t), std::sin(t), 0); }
};

/// Node i of the child is the mean of nodes i and i + 1 of the parent; with `bend`, its x gets bend * y^2.
class TestMean final : public Mapping {
 public:
  void declare(DataTable& table) override {
    table.addLink("input", input_).help("parent");
    table.addLink("output", output_).help("child");
    table.add("bend", bend_).help("zero: linear");
  }
  State& input() const override { return *input_.get(); }
  State& output() const override { return *output_.get(); }
  bool isLinear() const override { return bend_ == 0; }
  void apply(Rows x) const override {
    y_.resize(output().size());
    forEach([&](Index i, Index a, Index c) {
      x[c] = 0.5 * (x[a] + x[a + 1]);
      y_[i] = x[c].y();
      x[c].x() += bend_ * x[c].y() * x[c].y();
    });
  }
  void applyJ(Rows v) const override {
    forEach([&](Index i, Index a, Index c) {
      v[c] = 0.5 * (v[a] + v[a + 1]);
      v[c].x() += 2 * bend_ * y_[i] * v[c].y();
    });
  }
  void applyJT(Rows f) const override {
    forEach([&](Index i, Index a, Index c) {
      Vec3 force = f[c];
      force.y() += 2 * bend_ * y_[i] * force.x();
      f[a] += 0.5 * force;
      f[a + 1] += 0.5 * force;
    });
  }
  void addJacobian(std::vector<JacobianBlock>& out) const override {
    forEach([&](Index i, Index a, Index c) {
      Mat3 block = 0.5 * Mat3::Identity();
      block(0, 1) = bend_ * y_[i];
      out.push_back({c, a, block});
      out.push_back({c, a + 1, block});
    });
  }
  void addCurvature(ConstRows v, Rows a) const override {
    forEach([&](Index, Index, Index c) { a[c].x() += 2 * bend_ * v[c].y() * v[c].y(); });
  }
  void addGeometricPattern(BlockPattern& pattern) const override {
    forEach([&](Index, Index a, Index) {
      const Index rows[2] = {a, a + 1};
      pattern.addClique(rows, 2);
    });
  }
  void addGeometricStiffness(ConstRows f, double factor, BlockMatrix& matrix) const override {
    forEach([&](Index, Index a, Index c) {
      Mat3 block = Mat3::Zero();
      block(1, 1) = factor * 2 * bend_ * f[c].x() * 0.25;
      for (Index i : {a, a + 1})
        for (Index j : {a, a + 1}) matrix.add(i, j, block);
    });
  }
  void addGeometricProduct(ConstRows f, ConstRows dx, double factor, Rows df) const override {
    forEach([&](Index, Index a, Index c) {
      const double force = factor * 2 * bend_ * f[c].x() * 0.5 * (dx[a].y() + dx[a + 1].y());
      df[a].y() += 0.5 * force;
      df[a + 1].y() += 0.5 * force;
    });
  }

 private:
  template <class Visit>
  void forEach(Visit visit) const {
    for (Index i = 0; i < output().size(); ++i) visit(i, input().firstRow() + i, output().firstRow() + i);
  }
  Link<State> input_{"mechanical state"}, output_{"mechanical state"};
  double bend_ = 0;
  mutable std::vector<double> y_;
};

}  // namespace

void registerTestComponents(Factory& factory) {
  factory.add<TestIntegrator>("TestIntegrator", "test");
  factory.add<TestSolver>("TestSolver", "test");
  factory.add<TestMesh>("TestMesh", "test");
  factory.add<TestLinearNet>("TestLinearNet", "test");
  factory.add<TestSprings>("TestSprings", "test");
  factory.add<TestUnsymmetric>("TestUnsymmetric", "test");
  factory.add<TestDrag>("TestDrag", "test");
  factory.add<TestPlane>("TestPlane", "test");
  factory.add<TestTurningPlane>("TestTurningPlane", "test");
  factory.add<TestMean>("TestMean", "test");
}

long assembliesOf(const Component& net) { return dynamic_cast<const Net&>(net).assemblies; }

}  // namespace stroma::test
