// SPDX-License-Identifier: LGPL-2.1-or-later
// A force field of a loaded scene, its system's vectors, and the checks that every force field must pass.
#pragma once
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <random>
#include <sstream>

#include "tests/support/quadratic_block.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {

/// |a - b| / max(|a|, |b|), 0 for two zeros.
inline double relativeDifference(ConstRows a, ConstRows b) {
  double difference = 0, scale = std::max(dot(a, a), dot(b, b));
  for (std::size_t i = 0; i < a.doubles(); ++i) difference += (a.data[i] - b.data[i]) * (a.data[i] - b.data[i]);
  return scale == 0 ? 0 : std::sqrt(difference / scale);
}

/// Sums of forces and of torques about the centroid, relative to the sums of magnitudes.
struct Momentum {
  double force = 0, torque = 0;
};
inline Momentum momentumOf(ConstRows x, ConstRows f) {
  Vec3 centre = Vec3::Zero(), force = Vec3::Zero(), torque = Vec3::Zero();
  for (Index i = 0; i < x.count; ++i) centre += x[i] / x.count;
  double magnitudes = 0, lever = 0;
  for (Index i = 0; i < x.count; ++i) {
    const Vec3 arm = x[i] - centre;
    force += f[i];
    torque += arm.cross(Vec3(f[i]));
    magnitudes += f[i].norm();
    lever += arm.norm() * f[i].norm();
  }
  return magnitudes == 0 ? Momentum{} : Momentum{force.norm() / magnitudes, torque.norm() / lever};
}

/// Between -1 and 1, as std::uniform_real_distribution makes it; that takes logarithms for each number without optimisation.
inline double betweenOnes(std::mt19937& random) {
  const double low = double(random()), high = double(random());
  return (low + high * 0x1p32) / 0x1p64 * 2 - 1;
}

// Over all nodes it calculates in numbers: tests are compiled without optimisation.
class FieldUnderTest {
 public:
  /// The first force field of type `type` in the scene, with the vectors of its system.
  FieldUnderTest(const std::string& scene, const std::string& type) : simulation_(simulationFromText(scene)) {
    for (const auto& system : simulation_.systems())
      for (ForceField* candidate : system->forceFields())
        if (candidate->type() == type && !field_) field_ = candidate, system_ = system.get();
    if (!field_) throw std::runtime_error("the scene has no " + type);
    const Index rows = system_->allRows();
    for (Vector* v : {&x, &v_zero, &direction, &velocity}) v->resize(rows);
    if (field_->traits().time_dependent) field_->setTime(0.37);
    rest();
    std::mt19937 random(7);
    for (Vector* v : {&direction, &velocity})
      for (Index i = 0; i < rows; ++i)
        for (int c = 0; c < 3; ++c) numbersOf(*v, i)[c] = betweenOnes(random);
  }

  void rest() {
    for (const State* state : system_->states())
      for (Index i = 0; i < state->size(); ++i) {
        const double* place = state->rest_position[std::size_t(i)].data();
        for (int c = 0; c < 3; ++c) numbersOf(x, state->firstRow() + i)[c] = place[c];
      }
  }
  /// A smooth stretch and twist of the whole body, a rotation, and noise of `noise` times the shortest edge scale.
  void deform(double noise, unsigned seed = 1) {
    rest();
    std::mt19937 random(seed);
    Mat3 f = Eigen::AngleAxisd(2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (int i = 0; i < 9; ++i) f(i / 3, i % 3) += 0.15 * betweenOnes(random);
    const double amount = noise * typicalEdge(), shift[] = {3, -2, 1}, *m = f.data();
    for (Index i = 0; i < x.count(); ++i) {
      double* p = numbersOf(x, i);
      const double p0 = p[0], p1 = p[1], p2 = p[2];
      for (int c = 0; c < 3; ++c)
        p[c] = m[c] * p0 + m[c + 3] * p1 + m[c + 6] * p2 + shift[c] + amount * betweenOnes(random);
    }
  }
  void moveRigidly() {
    rest();
    const Mat3 r = Eigen::AngleAxisd(2.5, Vec3(-1, 2, 0.5).normalized()).toRotationMatrix();
    for (Index i = 0; i < x.count(); ++i) x[i] = r * Vec3(x[i]) + Vec3(0.3, -0.2, 0.1);
  }

  Vector force() { return forceAt(x); }
  Vector forceAt(ConstRows at) {
    Vector f(x.count());
    field_->addForce(at, v_zero, f);
    return f;
  }
  Vector forceAt(ConstRows at, ConstRows v) {
    Vector f(x.count());
    field_->addForce(at, v, f);
    return f;
  }
  /// C d at (x, velocity).
  Vector dampingProduct(ConstRows d, double factor = 1) {
    forceAt(x, velocity);
    Vector df(x.count());
    field_->addDampingProduct(d, factor, df);
    return df;
  }
  /// K d at x (the tangent of a fresh force evaluation).
  Vector product(ConstRows d, double factor = 1) {
    force();
    Vector df(x.count());
    field_->addStiffnessProduct(d, factor, df);
    return df;
  }
  /// (f(x + h d) - f(x - h d)) / 2h
  Vector differenceOfForces(double step) {
    Vector a(x.count()), b(x.count());
    copy(x, a), copy(x, b);
    axpy(step, direction, a), axpy(-step, direction, b);
    Vector fa = forceAt(a), fb = forceAt(b), result(x.count());
    axpy(0.5 / step, fa, result), axpy(-0.5 / step, fb, result);
    return result;
  }
  /// The field's own K, assembled.
  BlockMatrix matrix() {
    force();
    BlockPattern pattern(x.count());
    field_->addPattern(pattern);
    BlockMatrix k(std::move(pattern));
    field_->prepareAssembly(k);
    field_->addStiffness(1, k);
    return k;
  }
  double typicalEdge() const {
    const State& state = field_->state();
    const auto size = [](const std::vector<Vec3>& places) {
      Vec3 low = Vec3::Constant(1e300), high = -low;
      for (const Vec3& place : places)
        for (int c = 0; c < 3; ++c) {
          const double p = place.data()[c];
          if (p < low.data()[c]) low.data()[c] = p;
          if (p > high.data()[c]) high.data()[c] = p;
        }
      return (high - low).norm();
    };
    const double rest = size(state.rest_position);  // zero where the rows are curvatures of a straight rod
    return (rest > 0 ? rest : size(state.position)) / std::cbrt(double(state.size()));
  }

  ForceField& field() { return *field_; }
  System& system() { return *system_; }
  Simulation& simulation() { return simulation_; }

  Vector x, v_zero, direction;
  Vector velocity;  ///< random [m/s]

 private:
  static double* numbersOf(Vector& vector, Index row) { return vector.rows().data + std::size_t(row) * row_doubles; }

  Simulation simulation_;
  ForceField* field_ = nullptr;
  System* system_ = nullptr;
};

/// `diagonal`, shape (rows, 9), has the diagonal blocks of a matrix.
inline void expectDiagonalOf(const BlockMatrix& matrix, const std::vector<double>& diagonal) {
  double worst = 0, largest = 0;
  for (std::size_t row = 0; row < diagonal.size() / 9; ++row)
    for (std::size_t i = 0; i < 9; ++i) {
      const double value = matrix.values()[std::size_t(matrix.diagonal()[row]) * 9 + i];
      ASSERT_TRUE(std::isfinite(value) && std::isfinite(diagonal[row * 9 + i])) << "row " << row;
      worst = std::max(worst, std::abs(value - diagonal[row * 9 + i])), largest = std::max(largest, std::abs(value));
    }
  EXPECT_LE(worst, 1e-12 * largest) << "matrix and diagonal differ";
}
/// Matrix, diagonal and products of the field are those of one K.
inline void expectMatrixOfProducts(FieldUnderTest& t) {
  const BlockMatrix k = t.matrix();
  Vector assembled(t.x.count());
  k.multiply(t.direction, assembled);
  EXPECT_LT(relativeDifference(assembled, t.product(t.direction)), 1e-12) << "matrix and product differ";
  std::vector<double> diagonal(std::size_t(t.x.count()) * 9, 0.);
  t.field().addStiffnessDiagonal(1, diagonal);
  expectDiagonalOf(k, diagonal);
}
inline void expectSymmetricProducts(FieldUnderTest& t) {
  Vector other(t.x.count());
  for (Index i = 0; i < other.count(); ++i) other[i] = Vec3(std::sin(i), std::cos(3 * i), std::sin(7 * i + 1));
  const Vector product = t.product(t.direction), turned = t.product(other);
  EXPECT_GT(dot(product, product), 0);
  EXPECT_NEAR(dot(other, product), dot(t.direction, turned),
              1e-12 * std::sqrt(dot(turned, turned) * dot(t.direction, t.direction)));
}

/// The organ of the repository, or another mesh, under TetrahedronFEMForceField with the given attributes.
inline std::string tetrahedraScene(const std::string& attributes,
                                   const std::string& mesh = STROMA_SOURCE_DIR "/scenes/meshes/organ_600.msh",
                                   const std::string& solver = "<SparseLDLSolver/>") {
  return "<Node name=\"root\" dt=\"0.01\"><Node name=\"body\"><EulerImplicitSolver/>" + solver +
         "<MeshGmshLoader name=\"loader\" filename=\"" + mesh +
         "\"/>"
         "<TetrahedronSetTopologyContainer src=\"@loader\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>"
         "<TetrahedronFEMForceField youngModulus=\"3000\" poissonRatio=\"0.4\" " +
         attributes + "/></Node></Node>";
}

/// Attributes of a block of n[0] x n[1] x n[2] nodes in hexahedra: boxes of three different edges, turned, or with every node moved
/// by up to a fifth of an edge.
inline std::string hexahedraText(bool boxes, const std::array<int, 3>& n) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  const Mat3 turn = Eigen::AngleAxisd(0.8, Vec3(1, -1, 2).normalized()).toRotationMatrix();
  const Vec3 edge(0.02, 0.015, 0.03);
  std::ostringstream position, cells;
  position.precision(17);
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        Vec3 p(i, j, k);
        if (!boxes) p += Vec3(uniform(random), uniform(random), uniform(random));
        position << (turn * edge.cwiseProduct(p)).transpose() << " ";
        if (i + 1 == n[0] || j + 1 == n[1] || k + 1 == n[2]) continue;
        const int first = (k * n[1] + j) * n[0] + i, row = n[0], layer = n[0] * n[1];
        for (int c : {0, 1, row + 1, row, layer, layer + 1, layer + row + 1, layer + row}) cells << first + c << " ";
      }
  return "position=\"" + position.str() + "\" hexahedra=\"" + cells.str() + "\"";
}

/// Such a block under HexahedronFEMForceField. `more`: components after the field.
inline std::string hexahedraScene(const std::string& attributes, bool boxes,
                                  const std::string& solver = "<SparseLDLSolver/>",
                                  const std::array<int, 3>& n = {4, 5, 3}, const std::string& more = "") {
  static std::map<std::pair<bool, std::array<int, 3>>, std::string> written;  // the same for all methods, and long
  std::string& block = written[{boxes, n}];
  if (block.empty()) block = hexahedraText(boxes, n);
  return "<Node name=\"root\" dt=\"0.01\"><Node name=\"body\"><EulerImplicitSolver/>" + solver +
         "<HexahedronSetTopologyContainer " + block + "/><MechanicalObject/><UniformMass totalMass=\"1\"/>"
         "<HexahedronFEMForceField youngModulus=\"3000\" poissonRatio=\"0.4\" " +
         attributes + "/>" + more + "</Node></Node>";
}

/// A variant of a method; `name` for messages, `attributes` for the scene.
struct Variant {
  std::string name, attributes;
  bool b_current = false;
  bool torque_free = false;  ///< Euler's law, at every shape without inverted elements
  bool is(const std::string& method) const { return name.rfind(method, 0) == 0; }
};

/// A kind of element on a mesh, with all variants that it has.
struct ElasticBody {
  std::string name, type;
  bool tetrahedra;
  std::function<std::string(const std::string& attributes)> scene;
  bool quadratic = false;

  /// The rotation of a tetrahedron, or of a point, minimises its energy, so that polar and svd exert no torque with any
  /// B.
  std::vector<Variant> variants(bool with_exact = true) const {
    std::vector<Variant> variants;
    for (const std::string word : {"small", "large", "polar", "svd", "nodal", "green"}) {
      if (word == "nodal" && !tetrahedra) continue;
      const bool rotated = word == "large" || word == "polar" || word == "svd";
      for (int update = 0; update < (rotated && !quadratic ? 3 : 1); ++update)
        for (int exact = 0; exact < (with_exact && word != "nodal" ? 2 : 1); ++exact) {
          Variant v;
          v.name = word + (update == 1 ? " B" : update == 2 ? " B and V" : "") + (exact ? " exact" : "");
          v.attributes = "method=\"" + word + "\"" + (update > 0 ? " updateStiffnessMatrix=\"true\"" : "") +
                         (update > 1 ? " updateVolume=\"true\"" : "") + (exact ? " tangent=\"exact\"" : "");
          v.b_current = update > 0;
          v.torque_free =
              update > 0 || word == "green" || ((tetrahedra || quadratic) && (word == "polar" || word == "svd"));
          variants.push_back(v);
          if (word == "nodal" || (word == "green" && tetrahedra)) continue;
          Variant mean = v, modes = v;
          mean.name += " mean dilatation", mean.attributes += " dilatation=\"mean\"";
          variants.push_back(mean);
          if (tetrahedra || quadratic || update > 0 || word == "green") continue;
          for (Variant* base : {&modes, &mean}) {
            base->name += " incompatible modes", base->attributes += " incompatibleModes=\"true\"";
            variants.push_back(*base);
          }
        }
    }
    return variants;
  }
};

inline const std::vector<ElasticBody>& elasticBodies() {
  static const std::vector<ElasticBody> bodies{
      {"tetrahedra", "TetrahedronFEMForceField", true, [](const std::string& a) { return tetrahedraScene(a); }},
      {"boxes", "HexahedronFEMForceField", false, [](const std::string& a) { return hexahedraScene(a, true); }},
      {"hexahedra", "HexahedronFEMForceField", false, [](const std::string& a) { return hexahedraScene(a, false); }},
      {"quadratic tetrahedra", "QuadraticTetrahedronFEMForceField", false,
       [](const std::string& a) { return quadraticScene(a); }, true}};
  return bodies;
}
inline const ElasticBody& bodyOfTetrahedra() { return elasticBodies()[0]; }

/// test(body, variant) for all, named in failures.
template <class Test>
void forEachElasticVariant(bool with_exact, Test&& test) {
  for (const ElasticBody& body : elasticBodies())
    for (const Variant& variant : body.variants(with_exact)) {
      SCOPED_TRACE(body.name + " " + variant.name);
      test(body, variant);
    }
}

}  // namespace stroma::test
