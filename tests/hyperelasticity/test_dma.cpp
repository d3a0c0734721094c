// SPDX-License-Identifier: LGPL-2.1-or-later
// The swinging disc of scenes/validation/dma.xml on its coarse mesh: the complex modulus from the torque on the plate.
// docs/validate/dma.py has the frequencies and the finer meshes.
#include <complex>
#include <numbers>

#include "tests/validation/scene_run.h"

#include <gtest/gtest.h>

namespace stroma::test {
namespace STROMA_TEST_FILE {

TEST(SwingingDisc, ModulusIsThatOfTheMaxwellModel) {
  using Complex = std::complex<double>;
  constexpr double radius = 0.01, height = 0.004, angle = 0.004, g0 = 770, w = 10;
  constexpr double alpha[2] = {0.235, 0.333}, tau[2] = {0.27, 0.03};
  constexpr int steps = 40, periods = 5;
  const double period = 2 * std::numbers::pi / w;
  Simulation s = validationScene("dma", {"/.dt=" + std::to_string(period / steps), "/disc/plate.pulsation=10",
                                         "/disc/law.viscousUpdate=exponential"});
  s.dropObservers();
  const System& system = *s.systems()[0];
  Complex torque = 0;
  for (int n = 1; n <= steps * periods; ++n) {
    const StepReport report = s.step();
    ASSERT_FALSE(report.diverged || report.unsolved) << report.reason;
    if (n <= steps * (periods - 1)) continue;
    double now = 0;
    for (Index i = 0; i < system.allRows(); ++i) {
      const Vec3& x = system.states()[0]->rest_position[i];
      if (std::abs(x.z() - height) < 1e-9) now -= x.x() * system.f[i].y() - x.y() * system.f[i].x();
    }
    torque += Complex(0, 2. / steps) * now * std::exp(Complex(0, -w * s.time()));
  }
  const Complex modulus = torque * 2. * height / (std::numbers::pi * std::pow(radius, 4) * angle);
  Complex expected = g0;
  for (int i = 0; i < 2; ++i) expected -= g0 * alpha[i] / (1. + Complex(0, w * tau[i]));
  std::printf("G* = %.1f + %.1f i Pa, closed form %.1f + %.1f i\n", modulus.real(), modulus.imag(), expected.real(),
              expected.imag());
  // 1,536 tetrahedra are too stiff by 5 %: the loss angle knows nothing of it
  EXPECT_LT(std::abs(modulus - expected), 0.06 * std::abs(expected));
  EXPECT_NEAR(std::arg(modulus), std::arg(expected), 2e-3);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
