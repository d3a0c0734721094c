// SPDX-License-Identifier: LGPL-2.1-or-later
// The contract of force fields, for every one in the factory: a component that is added is tested without a word here.
#include "tests/support/field_derivatives.h"
#include "tests/support/force_field_examples.h"

namespace stroma::test {
namespace {

/// `example` with the first element of type `type` given other attributes in front.
std::string withAttributes(std::string example, const std::string& type, const std::string& original,
                           const std::string& attributes) {
  const auto at = example.find("<" + original);
  EXPECT_NE(at, std::string::npos) << original;
  auto end = example.find('>', at);
  std::string element = example.substr(at, end - at);
  for (std::string name : {"method", "updateStiffnessMatrix", "updateVolume", "tangent"}) {  // ours win
    const auto found = attributes.find(name) == std::string::npos ? std::string::npos : element.find(" " + name + "=");
    if (found == std::string::npos) continue;
    const auto quote = element.find('"', element.find('"', found) + 1);
    element.erase(found, quote + 1 - found);
  }
  element.replace(1, original.size(), type + " " + attributes);
  return example.replace(at, end - at, element);
}

/// `mild`: no element is near a singular shape, where differences of forces and approximate tangents lose their
/// meaning.
/// `approximate`: by how much an approximate tangent may be off at strains of a tenth.
void expectConsistent(FieldUnderTest& t, const std::string& what, bool mild = true, double approximate = 0.3) {
  SCOPED_TRACE(what);
  const ForceTraits traits = t.field().traits();
  Vector f = traits.velocity_dependent ? t.forceAt(t.x, t.velocity) : t.force();
  ASSERT_GT(dot(f, f), 0) << "the thing tested is zero";
  ASSERT_TRUE(std::isfinite(dot(f, f)));
  f = t.force();

  const double step = 1e-6 * t.typicalEdge();
  if (traits.conservative) expectForceOfEnergy(t, f);

  Vector product = t.product(t.direction);
  if (!traits.has_stiffness) {
    EXPECT_EQ(dot(product, product), 0);
    return;
  }
  ASSERT_GT(dot(product, product), 0);
  Vector difference = t.differenceOfForces(step);
  const double error = relativeDifference(product, difference);
  if (traits.exact_tangent)
    EXPECT_LT(error, mild ? 1e-6 : 1e-5) << "product is not the derivative of the force";
  else {  // approximate by design: say by how much, and that it is the same in kind
    ::testing::Test::RecordProperty("tangent error of " + what, std::to_string(error));
    if (mild) {
      EXPECT_LT(error, approximate) << "at strains of a tenth";
    }
  }

  expectMatrixOfProducts(t);
  product = t.product(t.direction);
  Vector scaled = t.product(t.direction, -2.5);
  axpy(2.5, product, scaled);
  EXPECT_LT(std::sqrt(dot(scaled, scaled) / dot(product, product)), 1e-13) << "factor";

  if (traits.symmetric) expectSymmetricProducts(t);
  expectForceAndProductInOnePass(t);
}

/// C is the derivative of the force with respect to velocity, in all its forms.
void expectDamping(FieldUnderTest& t, const std::string& what) {
  SCOPED_TRACE(what);
  if (!t.field().traits().velocity_dependent) return;
  const double step = 1e-4;
  Vector a(t.x.count()), b(t.x.count());
  copy(t.velocity, a), copy(t.velocity, b);
  axpy(step, t.direction, a), axpy(-step, t.direction, b);
  const Vector fa = t.forceAt(t.x, a), fb = t.forceAt(t.x, b);
  Vector difference(t.x.count());
  axpy(0.5 / step, fa, difference), axpy(-0.5 / step, fb, difference);
  Vector product = t.dampingProduct(t.direction);
  ASSERT_GT(dot(product, product), 0);
  EXPECT_LT(relativeDifference(product, difference), 1e-8) << "C is not the derivative of the force";
  EXPECT_LE(dot(t.direction, product), 0) << "the damping drives";
  Vector scaled = t.dampingProduct(t.direction, -2.5);
  axpy(2.5, product, scaled);
  EXPECT_LT(std::sqrt(dot(scaled, scaled) / dot(product, product)), 1e-13) << "factor";

  BlockPattern pattern(t.x.count());
  t.field().addPattern(pattern);
  BlockMatrix c(std::move(pattern));
  t.field().prepareAssembly(c);
  t.field().addDamping(1, c);
  Vector assembled(t.x.count());
  c.multiply(t.direction, assembled);
  EXPECT_LT(relativeDifference(assembled, product), 1e-12) << "matrix and product differ";
  std::vector<double> diagonal(std::size_t(t.x.count()) * 9, 0.);
  t.field().addDampingDiagonal(1, diagonal);
  expectDiagonalOf(c, diagonal);
}

/// Internal forces: they vanish at rest, and their sums vanish at any shape. A warped tangent is exact where nothing is
/// strained, in any orientation.
void expectBalanced(FieldUnderTest& t, const std::string& what, bool rotation_free) {
  SCOPED_TRACE(what);
  const ForceTraits traits = t.field().traits();
  t.deform(0.03);
  Vector f = t.force();
  const double scale = std::sqrt(dot(f, f));
  if (traits.forces_balance) {
    EXPECT_LT(momentumOf(t.x, f).force, 1e-12) << "Newton's law";
  }
  if (traits.torques_balance) {
    EXPECT_LT(momentumOf(t.x, f).torque, 1e-12) << "Euler's law";
  }
  if (!traits.forces_balance) return;
  t.rest();
  f = t.force();
  EXPECT_LT(std::sqrt(dot(f, f)), 1e-11 * scale) << "force at rest";
  if (rotation_free) t.moveRigidly();
  const double error = relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6 * t.typicalEdge()));
  EXPECT_LT(error, 1e-5) << "tangent of the unstrained shape";
}

TEST(ForceFieldContract, EveryRegisteredForceField) {
  modules().openAll();
  int tested = 0;
  for (const ComponentEntry* entry : factory().entries()) {
    if (!dynamic_cast<ForceField*>(factory().make(entry->type).get())) continue;
    const std::string example = exampleOf(entry->type);
    ASSERT_FALSE(example.empty()) << entry->type;
    const std::string original = fieldOf(example, entry->type);
    ASSERT_FALSE(original.empty()) << entry->type << ": its example has no force field";
    const bool warped_only = entry->type == "TriangularFEMForceFieldOptim";  // of its strain there is no exact tangent
    FieldUnderTest t(withAttributes(example, entry->type, original, warped_only ? "tangent=\"warped\"" : ""), entry->type);
    if (!t.field().state().hasPointsOnly()) continue;  // tests/beams has the contract of frames
    t.deform(0.03);
    expectConsistent(t, entry->type, true, warped_only ? 0.5 : 0.3);
    expectDamping(t, entry->type);
    expectBalanced(t, entry->type, true);
    ++tested;
  }
  EXPECT_GE(tested, 5);
}

TEST(ForceFieldContract, EveryElasticVariant) {
  forEachElasticVariant(true, [](const ElasticBody& body, const Variant& variant) {
    for (double noise : {0.02, 0.25}) {
      FieldUnderTest t(body.scene(variant.attributes), body.type);
      t.deform(noise);
      expectConsistent(t, body.name + " " + variant.name + " noise " + std::to_string(noise), noise < 0.1);
    }
  });
}

/// A warped tangent leaves out how rotations and gradients change, which stress alone feels: its error is of the first
/// order in the strain, so half the strain has half the error.
TEST(ForceFieldContract, WarpedTangentsErrByTheOrderOfTheStrain) {
  int tested = 0;
  forEachElasticVariant(false, [&](const ElasticBody& body, const Variant& variant) {
    FieldUnderTest t(body.scene(variant.attributes), body.type);
    if (t.field().traits().exact_tangent) return;
    const auto error = [&t](double strain) {
      t.moveRigidly();
      std::mt19937 random(3);
      std::uniform_real_distribution<double> uniform(-1, 1);
      for (Index i = 0; i < t.x.count(); ++i)
        t.x[i] += strain * t.typicalEdge() * Vec3(uniform(random), uniform(random), uniform(random));
      return relativeDifference(t.product(t.direction), t.differenceOfForces(1e-6 * t.typicalEdge()));
    };
    const double whole = error(0.01), half = error(0.005);
    RecordProperty(body.name + " " + variant.name, std::to_string(whole));
    EXPECT_LT(whole, 5 * 0.01);
    EXPECT_NEAR(half, whole / 2, whole / 20);
    ++tested;
  });
  EXPECT_GT(tested, 30);
}

TEST(ForceFieldContract, OwnMatrixGivesTheSameProduct) {
  forEachElasticVariant(true, [](const ElasticBody& body, const Variant& variant) {
    FieldUnderTest free(body.scene(variant.attributes + " assembling=\"false\""), body.type);
    FieldUnderTest kept(body.scene(variant.attributes + " assembling=\"true\""), body.type);
    free.deform(0.1), kept.deform(0.1);
    EXPECT_LT(relativeDifference(free.product(free.direction), kept.product(kept.direction)), 1e-12);
    kept.deform(0.1, 5), free.deform(0.1, 5);  // the matrix follows the shape
    EXPECT_LT(relativeDifference(free.product(free.direction), kept.product(kept.direction)), 1e-12);
  });
}

TEST(ForceFieldContract, RestAndRigidMotion) {
  forEachElasticVariant(false, [](const ElasticBody& body, const Variant& variant) {
    FieldUnderTest t(body.scene(variant.attributes), body.type);
    expectBalanced(t, variant.name, !variant.is("small"));
    t.deform(0.1);
    Vector strong = t.force();
    const double scale = std::sqrt(dot(strong, strong));
    t.rest();
    Vector f = t.force();
    EXPECT_LT(std::sqrt(dot(f, f)), 1e-12 * scale);
    EXPECT_LT(t.field().energy(t.x), 1e-20 * scale);
    t.moveRigidly();
    f = t.force();
    if (variant.is("small"))
      EXPECT_GT(std::sqrt(dot(f, f)), 0.1 * scale) << "pure linear elasticity swells when it turns";
    else
      EXPECT_LT(std::sqrt(dot(f, f)), 1e-11 * scale);
  });
}

void expectMaterialOneACell(const ElasticBody& body) {
  SCOPED_TRACE(body.name);
  FieldUnderTest one(body.scene("method=\"polar\""), body.type);
  const std::size_t count = [&] {
    std::vector<double> j;
    one.field().cellField("J", one.x, j);
    return j.size();
  }();
  std::string list, twice;
  for (std::size_t e = 0; e < count; ++e) list += "3000 ", twice += e < count / 2 ? "3000 " : "6000 ";
  FieldUnderTest same(body.scene("method=\"polar\" localStiffnessFactor=\"1\""), body.type);
  one.deform(0.1), same.deform(0.1);
  EXPECT_EQ(relativeDifference(one.force(), same.force()), 0);
  const std::string base = body.scene("method=\"polar\"");
  auto with = [&](const std::string& moduli) {
    std::string text = base;
    const std::string old = "youngModulus=\"3000\"";
    return text.replace(text.find(old), old.size(), "youngModulus=\"" + moduli + "\"");
  };
  FieldUnderTest listed(with(list), body.type), stiffer(with(twice), body.type);
  listed.deform(0.1), stiffer.deform(0.1);
  EXPECT_EQ(relativeDifference(one.force(), listed.force()), 0);
  const double energy = one.field().energy(one.x), more = stiffer.field().energy(stiffer.x);
  EXPECT_GT(more, 1.2 * energy);
  EXPECT_LT(more, 2 * energy);
  EXPECT_NE(problemsOf(with("3000 4000")).find("youngModulus has 2 values"), std::string::npos);
}
TEST(ForceFieldContract, MaterialOneACell) {
  for (const ElasticBody& body : elasticBodies()) expectMaterialOneACell(body);
}

/// Cells that cover the body twice share its stiffness, not its stress.
TEST(ForceFieldContract, StressDoesNotDependOnTheCutting) {
  const auto stress = [](const std::string& cutting) {
    FieldUnderTest t(
        "<Node name=\"root\"><RegularGridTopology name=\"grid\" n=\"3 3 3\" min=\"0 0 0\" max=\"1 1 1\"/>"
        "<Node name=\"body\"><EulerImplicitSolver/><CGLinearSolver/><TetrahedronSetTopologyContainer name=\"tets\"/>"
        "<Hexa2TetraTopologicalMapping input=\"@../grid\" output=\"@tets\" cutting=\"" +
            cutting +
            "\"/>"
            "<MechanicalObject/><UniformMass totalMass=\"1\"/><TetrahedronFEMForceField youngModulus=\"3000\" "
            "poissonRatio=\"0.25\" method=\"small\"/></Node></Node>",
        "TetrahedronFEMForceField");
    for (Index i = 0; i < t.x.count(); ++i) t.x[i] += Vec3(0.01 * t.x[i].x(), 0, 0);
    std::vector<double> von_mises;
    t.field().cellField("vonMises", t.x, von_mises);
    for (double value : von_mises) EXPECT_NEAR(value, 3000 / 1.25 * 0.01, 1e-9);  // 2 mu eps
    return std::make_pair(von_mises.size(), t.field().energy(t.x));
  };
  const auto five = stress("five"), ten = stress("ten");
  EXPECT_EQ(five.first * 2, ten.first);
  EXPECT_NEAR(five.second, ten.second, 1e-12 * five.second);
}

TEST(ForceFieldContract, VariantsWithoutMeaningAreRefused) {
  const auto expectRefused = [](const ElasticBody& body, const std::string& attributes, const std::string& words) {
    const std::string problems = problemsOf(body.scene(attributes));
    EXPECT_NE(problems.find(words), std::string::npos) << attributes << ": " << problems;
  };
  for (const ElasticBody& body : elasticBodies()) {
    SCOPED_TRACE(body.name);
    const std::string words = body.quadratic ? "does not exist for" : "no meaning for method";
    expectRefused(body, "method=\"small\" updateStiffnessMatrix=\"true\"", words);
    expectRefused(body, "method=\"green\" updateStiffnessMatrix=\"true\"", words);
    expectRefused(body, "method=\"green\" tangent=\"warped\"", "no warped tangent");
    expectRefused(body, "method=\"polar\" updateVolume=\"true\"", "updateVolume");
    expectRefused(body, "method=\"poler\"", "polar");
    expectRefused(body, "template=\"Vec3,Prism\"", "Vec3,");
    expectRefused(body, body.tetrahedra ? "method=\"nodal\" tangent=\"exact\"" : "method=\"nodal\"",
                  body.tetrahedra  ? "no exact tangent"
                  : body.quadratic ? "method nodal does not exist for a quadratic tetrahedron"
                                   : "method nodal does not exist for a hexahedron");
    if (body.quadratic)
      expectRefused(body, "method=\"polar\" updateStiffnessMatrix=\"true\"",
                    "does not exist for a quadratic tetrahedron");
  }
  for (const std::size_t hexahedra : {1, 2}) {
    const auto expectOfModes = [&](const std::string& attributes, const std::string& words) {
      expectRefused(elasticBodies()[hexahedra], "incompatibleModes=\"true\" " + attributes, words);
    };
    expectOfModes("method=\"green\"", "method green has no incompatible modes");
    expectOfModes("method=\"svd\" updateStiffnessMatrix=\"true\"", "B cannot be updated");
    expectOfModes("method=\"polar\" polarOf=\"edges\"", "polarOf=\"gradient\"");
  }
  expectRefused(bodyOfTetrahedra(), "incompatibleModes=\"true\"", "incompatibleModes");
  for (const char* method : {"nodal", "green"})
    expectRefused(bodyOfTetrahedra(), "dilatation=\"mean\" method=\"" + std::string(method) + "\"",
                  "has no mean dilatation");
  expectRefused(bodyOfTetrahedra(), "method=\"nodal\" updateStiffnessMatrix=\"true\"", "no meaning for method nodal");
}

}  // namespace
}  // namespace stroma::test
