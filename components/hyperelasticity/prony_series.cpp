// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/prony_series.h"

#include <fmt/format.h>

#include <cmath>

namespace stroma {

PronyStep pronyStep(PronyUpdate update, double alpha, double tau, double h) {
  if (update == PronyUpdate::backward) return {h * alpha / (h + tau), tau / (h + tau), 0};
  const double z = h / tau;
  if (z == 0) return {0, 1, 0};
  const double kept = std::exp(-z), q = -std::expm1(-z) / z;
  // 1 - q and q - kept cancel in short steps: their series
  if (z < 1e-3) return {alpha * z * (0.5 - z * (1. / 6 - z / 24)), kept, alpha * z * (0.5 - z * (1. / 3 - z / 8))};
  return {alpha * (1 - q), kept, alpha * (q - kept)};
}

void PronyAttributes::declare(DataTable& table) {
  table.add("viscous", viscous_).help("relax the stress by the Prony series of ParameterAlpha and ParameterTau");
  table.add("ParameterAlpha", series_.alpha)
      .unit("-")
      .min(0)
      .help("of each term, the share of the instantaneous modulus that relaxes; together at most 1");
  table.add("ParameterTau", series_.tau).unit("s").min(0, false).help("relaxation time of each term");
  table.addChoice("viscousUpdate", series_.update, {"backward", "exponential"})
      .help("backward: first order in the time step, as published; exponential: second order");
  table.addChoice("viscousPart", series_.part, {"all", "deviatoric"})
      .help("all of the stress relaxes; or that of the change of shape, and the body keeps its bulk modulus");
}

PronySeries PronyAttributes::read(const Component& component) const {
  const bool given = !series_.alpha.empty() || !series_.tau.empty();
  if (given && !component.data().find("viscous")->isSet())
    throw ComponentError("a Prony series is given, and not whether it is used", "viscous=\"true\" or \"false\"");
  if (!viscous_) return {};
  if (series_.alpha.size() != series_.tau.size() || !given)
    throw ComponentError(
        fmt::format("ParameterAlpha has {} values and ParameterTau {}", series_.alpha.size(), series_.tau.size()),
        "a share and a relaxation time for each term");
  double sum = 0;
  for (double alpha : series_.alpha) sum += alpha;
  if (sum > 1)
    throw ComponentError(fmt::format("the shares of ParameterAlpha sum to {:g}", sum),
                         "at most 1: the rest is the relaxed modulus");
  return series_;
}

}  // namespace stroma
