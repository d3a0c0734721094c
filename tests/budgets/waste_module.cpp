// SPDX-License-Identifier: LGPL-2.1-or-later
// An observer that wastes: what budgets must find by its name. Its module counts instructions too.
//
// Example:
// <Node name="root">
//   <MechanicalObject position="0 0 0"/>
//   <Waste what="allocation"/>
// </Node>
#include <cstdlib>

#include "framework/scene/abi.h"
#include "framework/scene/factory.h"
#include "framework/scene/modules.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/simulation.h"
#include "tests/budgets/instruction_counter.h"

namespace {

using namespace stroma;

class Waste final : public Observer {
 public:
  void declare(DataTable& table) override {
    table.addChoice("what", what_, {"nothing", "allocation", "stress"}).help("what is wasted in each step");
  }
  void afterStep(const Simulation& simulation, const StepContext&) override {
    if (what_ == What::allocation) {
      void* memory = std::malloc(8);
      asm volatile("" : : "r"(memory) : "memory");  // a compiler leaves out what nobody sees
      std::free(memory);
    }
    if (what_ != What::stress) return;
    const System& system = *simulation.systems().front();
    const ForceField& field = *system.forceFields().front();
    field.cellField(field.cellFields().front(), system.x, stress_);
  }
  std::string describe() const override { return "wastes"; }

 private:
  enum class What : int { nothing, allocation, stress };
  What what_ = What::nothing;
  std::vector<double> stress_;
};

}  // namespace

STROMA_COMPONENT(waste_module) { factory.add<Waste>("Waste", "wastes something in each step"); }

extern "C" __attribute__((visibility("default"))) const stroma::ModuleInfo* stroma_module() {
  static const stroma::ModuleInfo info{STROMA_ABI, "waste", stroma_register_waste_module};
  countInstructionsOfAStep();
  return &info;
}
