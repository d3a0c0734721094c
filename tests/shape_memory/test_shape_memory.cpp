// SPDX-License-Identifier: LGPL-2.1-or-later
// Shape memory: targets against closed forms, invariance, the laws of Newton and Euler, recovery.
#include <Eigen/Geometry>

#include "framework/algebra/parallel.h"
#include "framework/mesh/topology.h"
#include "tests/support/dense_algebra.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace {

const std::string type = "ShapeMemoryForceField";

std::string organ(const std::string& attributes, const std::string& solver = "<SparseLDLSolver/>",
                  const std::string& more = "", const std::string& integrator = "<EulerImplicitSolver/>",
                  const std::string& dt = "0.01") {
  return "<Node name=\"root\" dt=\"" + dt + "\" gravity=\"0 0 0\"><Node name=\"body\">" + integrator + solver +
         "<MeshGmshLoader name=\"loader\" filename=\"" STROMA_SOURCE_DIR
         "/scenes/meshes/organ_600.msh\"/><TetrahedronSetTopologyContainer src=\"@loader\"/><MechanicalObject/>"
         "<UniformMass totalMass=\"1\"/><ShapeMemoryForceField stiffness=\"100\" " +
         attributes + "/>" + more + "</Node></Node>";
}

/// A grid of hexahedra: inside nodes lie at the mean of their neighbours, nodes of the border do not.
std::string grid(const std::string& attributes, const std::string& n = "4 5 6") {
  return "<Node name=\"root\"><EulerImplicitSolver/><SparseLDLSolver/><RegularGridTopology n=\"" + n +
         "\" min=\"0 0 0\" max=\"0.3 0.4 0.5\"/><MechanicalObject/><UniformMass totalMass=\"1\"/>"
         "<ShapeMemoryForceField stiffness=\"100\" " +
         attributes + "/></Node>";
}

const char* const variants[] = {"",
                                "frame=\"triangle\"",
                                "nodes=\"contour\"",
                                "reaction=\"false\"",
                                "reaction=\"false\" frame=\"triangle\"",
                                "reaction=\"false\" tangent=\"target\"",
                                "ownWeight=\"1\""};

TEST(ShapeMemory, NoForceAtRestNorAfterARigidMotion) {
  for (const std::string attributes : variants)
    for (const std::string& scene : {organ(attributes), grid(attributes)}) {
      SCOPED_TRACE(attributes);
      FieldUnderTest t(scene, type);
      t.deform(0.1);
      const double scale = norm(t.force());
      ASSERT_GT(scale, 0);
      t.rest();
      EXPECT_LT(norm(t.force()), 1e-13 * scale);
      t.moveRigidly();
      EXPECT_LT(norm(t.force()), 1e-12 * scale);
      EXPECT_LT(t.field().energy(t.x), 1e-22 * scale * scale / 100);
    }
}

/// The target as the source describes it, written out for one node with Eigen: mean and best rotation (Kabsch).
Vec3 targetByEigen(const std::vector<Vec3>& rest, ConstRows x, Index node, const std::vector<Index>& neighbours) {
  Vec3 rest_mean = Vec3::Zero(), mean = Vec3::Zero();
  for (Index j : neighbours) {
    rest_mean += rest[j] / double(neighbours.size());
    mean += x[j] / double(neighbours.size());
  }
  Mat3 a = Mat3::Zero();
  for (Index j : neighbours) a += (x[j] - mean) * (rest[j] - rest_mean).transpose();
  return mean + kabschRotation(a) * (rest[node] - rest_mean);
}

TEST(ShapeMemory, PlainForceDrawsToTheTargetOfTheNeighbourhood) {
  for (const std::string& scene :
       {organ("reaction=\"false\" ownWeight=\"1e-6\""), grid("reaction=\"false\" ownWeight=\"1e-6\"")}) {
    FieldUnderTest t(scene, type);
    const Topology* mesh = t.field().find<Topology>(true);
    const Adjacency& around = mesh->mesh().nodesAroundNode();
    t.deform(0.2);
    const Vector f = t.force();
    const auto& rest = t.field().state().rest_position;
    for (Index i = 0; i < f.count(); ++i) {
      const std::vector<Index> list(around.values.begin() + around.start[i],
                                    around.values.begin() + around.start[i + 1]);
      const Vec3 expected = 100 * (targetByEigen(rest, t.x, i, list) - t.x[i]);
      // the node's own weight of 1e-6 moves the rotation by about as much
      EXPECT_LT((expected - f[i]).norm(), 1e-4 * 100 * t.typicalEdge()) << i;
    }
  }
}

/// The three of `nodes` that span the largest triangle.
std::vector<Index> largestTriangle(const std::vector<Vec3>& rest, const std::vector<Index>& nodes) {
  std::vector<Index> best;
  double largest = 0;
  for (const Index a : nodes)
    for (const Index b : nodes)
      for (const Index c : nodes) {
        const double area = (rest[b] - rest[a]).cross(rest[c] - rest[a]).norm();
        if (a < b && b < c && area > largest) largest = area, best = {a, b, c};
      }
  return best;
}

TEST(ShapeMemory, TheFrameOfATriangleIsThatOfTheLargest) {
  FieldUnderTest t(organ("reaction=\"false\" frame=\"triangle\" ownWeight=\"1e-6\""), type);
  const Adjacency& around = t.field().find<Topology>(true)->mesh().nodesAroundNode();
  t.deform(0.2);
  const Vector f = t.force();
  const auto& rest = t.field().state().rest_position;
  for (Index i = 0; i < f.count(); ++i) {
    const std::vector<Index> list(around.values.begin() + around.start[i], around.values.begin() + around.start[i + 1]);
    const Vec3 expected = 100 * (targetByEigen(rest, t.x, i, largestTriangle(rest, list)) - t.x[i]);
    EXPECT_LT((expected - f[i]).norm(), 1e-4 * 100 * t.typicalEdge()) << i;
  }
}

TEST(ShapeMemory, InvertedNeighbourhoodsGetARotationNotAReflection) {
  FieldUnderTest t(organ("reaction=\"false\" ownWeight=\"1e-6\""), type);
  const auto& rest = t.field().state().rest_position;
  const Adjacency& around = t.field().find<Topology>(true)->mesh().nodesAroundNode();
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] = Vec3(-rest[i].x(), rest[i].y(), rest[i].z());
  const Vector f = t.force();
  int compared = 0;
  for (Index i = 0; i < f.count(); ++i) {
    const std::vector<Index> list(around.values.begin() + around.start[i], around.values.begin() + around.start[i + 1]);
    const Vec3 expected = 100 * (targetByEigen(rest, t.x, i, list) - t.x[i]);
    compared += (expected - f[i]).norm() < 1e-3 * 100 * t.typicalEdge();
  }
  EXPECT_EQ(compared, int(f.count()));
}

TEST(ShapeMemory, ReactionHoldsNewtonsAndEulersLawsAndThePaperDoesNot) {
  for (const std::string attributes : {"", "frame=\"triangle\"", "nodes=\"contour\""})
    for (double noise : {0.01, 0.3, 3.0}) {
      FieldUnderTest t(organ(attributes), type), plain(organ(attributes + std::string(" reaction=\"false\"")), type);
      t.deform(noise), plain.deform(noise);
      const Momentum with = momentumOf(t.x, t.force()), without = momentumOf(plain.x, plain.force());
      SCOPED_TRACE(attributes + std::string(" noise ") + std::to_string(noise));
      EXPECT_LT(with.force, 1e-14);
      EXPECT_LT(with.torque, 1e-13);
      // the paper's plain form: the sum of the forces is a few percent of the sum of their magnitudes
      EXPECT_GT(without.force, 1e-3);
      RecordProperty("plain form, sum of forces at noise " + std::to_string(noise), std::to_string(without.force));
    }
}

TEST(ShapeMemory, UprightIsTheSameUntilANeighbourhoodInverts) {
  FieldUnderTest full(organ(""), type), upright(organ("reaction=\"upright\""), type);
  full.deform(0.05), upright.deform(0.05);
  EXPECT_EQ(relativeDifference(full.force(), upright.force()), 0);
  EXPECT_EQ(relativeDifference(full.product(full.direction), upright.product(full.direction)), 0);
  for (FieldUnderTest* t : {&full, &upright}) {
    t->rest();
    for (Index i = 0; i < t->x.count(); ++i) t->x[i].x() *= -1;
  }
  EXPECT_GT(relativeDifference(full.force(), upright.force()), 0.1);
  Vector product = upright.product(upright.direction), assembled(product.count());
  upright.matrix().multiply(upright.direction, assembled);
  EXPECT_LT(relativeDifference(product, assembled), 1e-12);
}

TEST(ShapeMemory, PlainTangentIsExactOnCollapsedShapesToo) {
  FieldUnderTest t(organ("reaction=\"false\""), type);
  t.deform(0.3);
  EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6 * t.typicalEdge())), 1e-6);
  FieldUnderTest held(organ("reaction=\"false\" tangent=\"target\""), type);
  held.deform(0.3);
  Vector product = held.product(held.direction);
  axpy(100, held.direction, product);
  EXPECT_EQ(norm(product), 0) << "K = -k I";
}

TEST(ShapeMemory, FewOrCollinearNeighboursHaveATarget) {
  const auto chain = [](const std::string& positions, const std::string& edges, const std::string& attributes) {
    return "<Node name=\"root\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject position=\"" + positions +
           "\"/><MeshTopology position=\"" + positions + "\" edges=\"" + edges +
           "\"/><UniformMass totalMass=\"1\"/><ShapeMemoryForceField stiffness=\"10\" " + attributes + "/></Node>";
  };
  // two nodes: each is the other's only neighbour, a spring of rest length 2 with twice the stiffness
  FieldUnderTest pair(chain("0 0 0  2 0 0", "0 1", ""), type);
  pair.x[1] = Vec3(0, 0, 5);
  Vector f = pair.force();
  EXPECT_NEAR(f[1].z(), -2 * 10 * 3, 1e-10);
  EXPECT_NEAR(f[0].z(), 2 * 10 * 3, 1e-10);
  EXPECT_NEAR(std::abs(f[1].x()) + std::abs(f[1].y()), 0, 1e-10);
  // a bent chain: the middle node's neighbours lie on a line, and it turns about that line without resistance
  FieldUnderTest bent(chain("0 0 0  1 1 0  2 0 0", "0 1 1 2", ""), type);
  bent.x[1] = Vec3(1, 0, 1);
  EXPECT_LT(norm(bent.force()), 1e-9);
  bent.x[1] = Vec3(1, 0, 2);
  f = bent.force();
  EXPECT_GT(norm(f), 1);
  EXPECT_LT(momentumOf(bent.x, f).torque, 1e-12);
}

// ---- motion ----

struct Bodies {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
Bodies momenta(const System& system) {
  Bodies sum;
  const std::vector<double>& mass = system.masses()[0]->lumped();
  for (Index i = 0; i < system.x.count(); ++i) {
    sum.linear += mass[i] * system.v[i];
    sum.angular += Vec3(system.x[i]).cross(mass[i] * Vec3(system.v[i]));
  }
  return sum;
}

TEST(ShapeMemory, AFreeBodyThatSpinsKeepsItsMomenta) {
  const auto run = [](const std::string& attributes, double& linear, double& angular) {
    Simulation simulation = simulationFromText(organ(attributes + " ", "", "", "<EulerExplicitSolver/>", "0.002"));
    System& system = *simulation.systems()[0];
    for (Index i = 0; i < system.x.count(); ++i)
      system.v[i] = Vec3(0.1, 0.2, -0.1) + Vec3(1, 2, 3).cross(Vec3(system.x[i])) +
                    0.3 * std::sin(double(i)) * Vec3(0.01, 0, 0.02);
    const Bodies start = momenta(system);
    for (int i = 0; i < 2000; ++i) ASSERT_FALSE(simulation.step().diverged);
    const Bodies end = momenta(system);
    linear = (end.linear - start.linear).norm() / start.linear.norm();
    angular = (end.angular - start.angular).norm() / start.angular.norm();
  };
  double linear = 1, angular = 1;
  run("", linear, angular);
  EXPECT_LT(linear, 1e-11);
  EXPECT_LT(angular, 1e-11);
  run("reaction=\"false\"", linear, angular);
  EXPECT_GT(std::max(linear, angular), 1e-4) << "the paper's plain form does not";
}

/// The largest distance to the rest shape after the best rigid motion, over the size of the body.
double distanceToRest(const State& state) {
  Vec3 mean = Vec3::Zero(), rest_mean = Vec3::Zero(), low = Vec3::Constant(1e9), high = -low;
  for (Index i = 0; i < state.size(); ++i) {
    const Vec3& p = state.rest_position[i];
    mean += state.x()[i] / state.size(), rest_mean += p / state.size();
    low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  Mat3 a = Mat3::Zero();
  for (Index i = 0; i < state.size(); ++i)
    a += (state.x()[i] - mean) * (state.rest_position[i] - rest_mean).transpose();
  const Mat3 r = kabschRotation(a);
  double worst = 0;
  for (Index i = 0; i < state.size(); ++i)
    worst = std::max(worst, (state.x()[i] - mean - r * (state.rest_position[i] - rest_mean)).norm());
  return worst / (high - low).norm();
}

/// Crushes every node of the body: to a plane, a line, a point, or random places; or drags one node far through it.
void crush(System& system, const std::string& how) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Vec3 mean = Vec3::Zero(), low = Vec3::Constant(1e9), high = -low;
  for (Index i = 0; i < system.x.count(); ++i) {
    mean += Vec3(system.x[i]) / system.x.count();
    low = low.cwiseMin(system.x[i]), high = high.cwiseMax(system.x[i]);
  }
  const double size = (high - low).norm();
  for (Index i = 0; i < system.x.count(); ++i) {
    Vec3 p = Vec3(system.x[i]) - mean;
    if (how == "plane") p.z() = 0;
    if (how == "line") p.y() = p.z() = 0;
    if (how == "point") p.setZero();
    if (how == "random") p = size * Vec3(uniform(random), uniform(random), uniform(random));
    if (how == "dragged" && i == 7) p -= 2 * p;
    if (how == "mirrored") p.x() = -p.x();
    system.x[i] = mean + p;
  }
}

struct Recovery {
  const char *attributes, *solver;
  std::vector<const char*> shapes;
};

TEST(ShapeMemory, RegainsItsShapeFromPlaneLinePointAndDisorder) {
  const char* cg = "<CGLinearSolver iterations=\"100\" tolerance=\"1e-8\"/>";
  // With a reaction always passed on there is an energy, and it has minima that disorder or a mirror image lead to.
  const Recovery recoveries[]{
      {"reaction=\"false\" tangent=\"target\"", cg, {"plane", "line", "point", "random", "dragged", "mirrored"}},
      {"reaction=\"upright\"", "<SparseLDLSolver/>", {"plane", "line", "point", "random", "dragged", "mirrored"}},
      {"", cg, {"plane", "line", "point", "dragged"}}};
  for (const Recovery& recovery : recoveries)
    for (const char* how : recovery.shapes) {
      SCOPED_TRACE(recovery.attributes + std::string(" ") + how);
      Simulation simulation = simulationFromText(
          organ(recovery.attributes, recovery.solver, "", "<EulerImplicitSolver rayleighMass=\"1\"/>", "0.1"));
      const State& state = *simulation.systems()[0]->states()[0];
      crush(*simulation.systems()[0], how);
      EXPECT_GT(distanceToRest(state), 0.05);
      for (int step = 0; step < 3000 && (step % 100 || distanceToRest(state) > 1e-6); ++step)
        ASSERT_FALSE(simulation.step().diverged);
      EXPECT_LT(distanceToRest(state), 1e-6);
    }
}

TEST(ShapeMemory, SameBitsForOneAndTwoThreads) {
  const auto hash = [](int count, const std::string& attributes) {
    setThreads(count);
    Simulation simulation = simulationFromText(
        "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -9.81 0\"><EulerImplicitSolver/><CGLinearSolver iterations=\"8\" "
        "tolerance=\"1e-12\"/><RegularGridTopology n=\"18 18 18\" min=\"0 0 0\" max=\"1 1 1\"/><MechanicalObject/>"
        "<UniformMass totalMass=\"1\"/><ShapeMemoryForceField stiffness=\"100\" " +
        attributes + "/><FixedProjectiveConstraint indices=\"0 1 2 3 4\"/></Node>");
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(simulation.step().diverged);
    setThreads(1);
    return simulation.stateHash();
  };
  for (const std::string attributes : {"", "reaction=\"false\" tangent=\"target\"", "nodes=\"contour\""})
    EXPECT_EQ(hash(1, attributes), hash(2, attributes)) << attributes;
}

TEST(ShapeMemory, BadInputIsSaid) {
  EXPECT_NE(problemsOf(organ("tangent=\"target\"")).find("reaction"), std::string::npos);
  EXPECT_NE(problemsOf(organ("reaction=\"upright\" frame=\"triangle\"")).find("plane"), std::string::npos);
  EXPECT_NE(problemsOf(organ("frame=\"tringle\"")).find("triangle"), std::string::npos);
  EXPECT_NE(problemsOf("<Node name=\"root\"><EulerExplicitSolver/><MechanicalObject position=\"0 0 0 1 0 0\"/>"
                       "<MeshTopology position=\"0 0 0 1 0 0\"/><UniformMass totalMass=\"1\"/>"
                       "<Phymul stiffness=\"1\"/></Node>")
                .find("no node has neighbours"),
            std::string::npos);
  EXPECT_NE(problemsOf(organ("reaction=\"false\"", "<CGLinearSolver/>")).find("not symmetric"), std::string::npos);
}

}  // namespace
}  // namespace stroma::test
