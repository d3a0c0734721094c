// SPDX-License-Identifier: LGPL-2.1-or-later
// After the first step, a step takes no memory from the heap. Counts every operator new, malloc, calloc, realloc and
// aligned allocation of the process, modules and libraries included, while the steps run. One exception that is not
// ours: a factorisation by CHOLMOD takes its work space (two blocks) and gives it back.
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <memory>

#include "framework/simulation/simulation.h"
#include "tests/support/field_under_test.h"
#include "tests/support/scene_text.h"

namespace {

bool counting = false;  ///< read by a builtin: without optimisation std::atomic calls functions, and each malloc reads it
/// By malloc and aligned_alloc, which C++ takes memory with; by the functions that only C libraries call.
std::atomic<long> allocations{0}, in_libraries{0};

void note(std::atomic<long>& kind = allocations) {
  if (__atomic_load_n(&counting, __ATOMIC_RELAXED)) ++kind;
}

}  // namespace

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool can_count = false;  // a sanitizer has its own malloc
#else
constexpr bool can_count = true;

// operator new calls malloc, so counting in these sees everything
#pragma GCC visibility push(default)
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_calloc(std::size_t, std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);
extern "C" void* malloc(std::size_t size) {
  note();
  return __libc_malloc(size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
  note(in_libraries);
  return __libc_calloc(count, size);
}
extern "C" void* realloc(void* old, std::size_t size) {
  note(in_libraries);
  return __libc_realloc(old, size);
}
extern "C" void* memalign(std::size_t alignment, std::size_t size) {
  note(in_libraries);
  return __libc_memalign(alignment, size);
}
extern "C" int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  note(in_libraries);
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : ENOMEM;
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note();
  return __libc_memalign(alignment, size);
}
#pragma GCC visibility pop
#endif

namespace stroma {
namespace {

TEST(Allocations, TheCounterCounts) {
  if (!can_count) GTEST_SKIP() << "a sanitizer has its own malloc";
  allocations = in_libraries = 0;
  counting = true;
  ::operator delete(::operator new(8));
  const Vector vector(10);
  counting = false;
  EXPECT_EQ(allocations, 2);
  counting = true;
  std::free(std::realloc(std::calloc(3, 3), 100));
  counting = false;
  EXPECT_EQ(in_libraries, 2);
}

class AllocationsOfScene : public testing::TestWithParam<const char*> {};

TEST_P(AllocationsOfScene, NoneAfterTheFirstStep) {
  if (!can_count) GTEST_SKIP() << "a sanitizer has its own malloc";
  Factory factory;
  Modules modules(factory);
  const std::string file = std::string(STROMA_SOURCE_DIR "/scenes/examples/") + GetParam();
  Simulation simulation(loadScene(file, {}, factory, modules));
  simulation.dropObservers();
  ASSERT_FALSE(simulation.step().diverged);
  allocations = in_libraries = 0;
  long factorisations = 0;
  bool diverged = false;
  counting = true;
  for (int i = 0; i < 5; ++i) {
    const StepReport report = simulation.step();
    factorisations += report.factorisations;
    diverged = diverged || report.diverged;
  }
  counting = false;
  EXPECT_FALSE(diverged);
  EXPECT_LE(allocations, 2 * factorisations);
  if (factorisations == 0) {
    EXPECT_EQ(in_libraries, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Examples, AllocationsOfScene,
                         testing::Values("organ.xml", "cantilever.xml", "explicit.xml", "ten_tetrahedra.xml",
                                         "mesh_matrix_mass.xml", "partial_fixed.xml", "breathing.xml",
                                         "organ_condensed.xml"));

/// Every method and variant of elastic elements, without a matrix and with one of their own.
TEST(Allocations, NoneInStepsOfAnyElasticVariant) {
  if (!can_count) GTEST_SKIP() << "a sanitizer has its own malloc";
  int tested = 0;
  test::forEachElasticVariant(true, [&](const test::ElasticBody& body, const test::Variant& variant) {
    for (const char* assembling : {"false", "true"}) {
      std::string scene = body.scene(variant.attributes + " assembling=\"" + assembling + "\"");
      const std::string direct = "<SparseLDLSolver/>";
      scene.replace(scene.find(direct), direct.size(), "<CGLinearSolver iterations=\"5\" tolerance=\"1e-9\"/>");
      std::unique_ptr<Simulation> simulation;
      try {
        simulation = std::make_unique<Simulation>(test::sceneFromText(scene));
        simulation->step();
      } catch (const SceneError&) {
        continue;  // conjugate gradients refuse a tangent that is not symmetric
      }
      allocations = in_libraries = 0;
      counting = true;
      for (int i = 0; i < 3; ++i) simulation->step();
      counting = false;
      EXPECT_EQ(allocations, 0) << assembling;
      EXPECT_EQ(in_libraries, 0) << assembling;
      ++tested;
    }
  });
  EXPECT_GT(tested, 80);
}

void expectNoneInSteps(Simulation& simulation) {
  ASSERT_FALSE(simulation.step().diverged);
  allocations = in_libraries = 0;
  bool diverged = false;
  counting = true;
  for (int i = 0; i < 5; ++i) diverged = simulation.step().diverged || diverged;
  counting = false;
  EXPECT_FALSE(diverged);
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(in_libraries, 0);
}

std::string beam(const std::string& integrator, const std::string& more = {}, const std::string& method = "small") {
  return "<" + integrator + R"(/><CGLinearSolver iterations="30" tolerance="1e-8"/>
    <RegularGridTopology n="3 3 5" min="0 0 0" max="0.1 0.1 0.3"/><MechanicalObject name="dofs"/>
    <UniformMass totalMass="1"/><HexahedronFEMForceField youngModulus="5000" poissonRatio="0.3" method=")" +
         method + R"("/><FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/>)" + more;
}

/// Products that go through relations, ties and mappings.
TEST(Allocations, NoneInStepsOfCoupledNodes) {
  if (!can_count) GTEST_SKIP() << "a sanitizer has its own malloc";
  const std::string couplings[] = {
      "<LinearRelationProjectiveConstraint indices='36 37 38  39 40 41' coefficients='1 -2 1'/>",
      "<AttachProjectiveConstraint indices1='36 37' indices2='44 43' twoWay='1'/>",
      "<Node name='ends'><MechanicalObject position='0 0 0.3  0.1 0.1 0.3'/><SubsetMapping indices='36 44'/>"
      "<SpringForceField springsIndices1='0' springsIndices2='1' lengths='0.1' stiffness='100'/></Node>",
      "<Node name='inside'><MechanicalObject position='0.02 0.03 0.27  0.08 0.07 0.29'/><BarycentricMapping/>"
      "<SpringForceField springsIndices1='0' springsIndices2='1' lengths='0.1' stiffness='100'/></Node>"};
  for (const std::string& coupling : couplings)
    for (const auto& [integrator, method] : {std::pair("EulerImplicitSolver", "small"), {"EulerImplicitSolver", "svd"},
                                             {"EulerImplicitSolver newtonIterations='30'", "svd"}}) {
      SCOPED_TRACE(coupling + integrator + method);
      std::string body = beam(integrator, coupling, method);
      const std::string solver = "<CGLinearSolver ";
      body.insert(body.find(solver) + solver.size(), "template='GraphScattered' ");
      Simulation simulation(test::sceneFromText("<Node name='root' dt='0.005' gravity='0 -1 0'>" + body + "</Node>"));
      expectNoneInSteps(simulation);
      EXPECT_GT(simulation.systems().front()->counts.products, 0);
    }
}

/// Each with a memory, which has to be that of before when the other one fails.
TEST(Allocations, NoneInStepsOfTwoBodies) {
  if (!can_count) GTEST_SKIP() << "a sanitizer has its own malloc";
  for (const std::string integrator :
       {"BDFOdeSolver order='2'", "NewmarkImplicitSolver", "CentralDifferenceSolver", "VariationalSymplecticSolver",
        "StaticSolver", "CondensedStaticSolver", "CondensedDynamicSolver"}) {
    SCOPED_TRACE(integrator);
    Simulation simulation(test::sceneFromText("<Node name='root' dt='0.0005' gravity='0 -1 0'><Node name='a'>" +
                                              beam(integrator) + "</Node><Node name='b'>" + beam(integrator) +
                                              "</Node></Node>"));
    expectNoneInSteps(simulation);
  }
}

TEST(Allocations, NoneInStaticsWhereWhatHoldsANodeTurns) {
  if (!can_count) GTEST_SKIP() << "a sanitizer has its own malloc";
  Simulation simulation(test::sceneFromText("<Node name='root' dt='0.01' gravity='0 -1 0'>" +
                                            beam("StaticSolver", "<TestTurningPlane indices='40'/>") + "</Node>"));
  expectNoneInSteps(simulation);
}

}  // namespace
}  // namespace stroma
