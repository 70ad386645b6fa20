#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/outcome.h"
#include "estimate/power_model.h"
#include "types/site.h"

namespace vildar {

/// What is known of each parameter: absent: nothing; std 0: exactly; else a normal prior. The
/// acceleration counts as exactly zero unless told otherwise.
using PowerKnowledge = std::array<std::optional<Uncertain>, kPowerParameters>;
PowerKnowledge nothing_known();

/// Speed wanted from the power that one vehicle sends to one receiver. Spans outlive the call.
struct PowerProblem {
  std::span<const double> time_s, power_w;
  /// Noise of a sample: one value each, one for all, or none: then taken from the residuals.
  std::span<const double> sigma_w;
  PowerSetting setting;
  PowerKnowledge known = nothing_known();
  double reference_s = 0.0;  ///< time at which speed, range and acceleration hold
};

enum class PowerStop {
  closed_form,  ///< nothing to iterate
  converged,    ///< the next step would be below a thousandth of the parameters' sigmas
  all_samples,  ///< a recursion that has seen every sample
};

struct PowerEstimate {
  PowerVector value = PowerVector::Zero();
  PowerMatrix covariance = PowerMatrix::Zero();  ///< zero for what is known exactly
  double reference_s = 0.0;
  std::int64_t samples_used = 0;
  std::int64_t samples_outside = 0;  ///< left out: not finite, or outside the estimator's domain
  int iterations = 0;
  /// Sum of squared whitened residuals, priors included, per degree of freedom; exactly 1 where the
  /// noise was taken from the residuals.
  double chi2_per_dof = 0.0;
  double noise_sigma_w = 0.0;  ///< of a sample, as used; the mean where samples differ
  PowerStop stop = PowerStop::closed_form;

  double speed_mps() const { return value[kPowerSpeed]; }
  double speed_sigma_mps() const;
  /// 95 % interval of the speed. Where the scale is uncertain by much (K not exact) the posterior
  /// is nearer to normal in ln V; the interval is then so.
  std::array<double, 2> speed_95_mps(bool scale_uncertain = false) const;
};

/// Why there is no estimate: the named reason and the sentence for people.
struct PowerRefusal {
  Miss miss = Miss::too_few_samples;
  std::string reason;  ///< e.g. "speed is not observable: K and d both unknown"
};
using PowerOutcome = std::variant<PowerEstimate, PowerRefusal>;

/// Parameters that are not known exactly and that the setting depends on, in order.
std::vector<PowerParameter> free_parameters(const PowerKnowledge& known,
                                            const PowerSetting& setting);

/// The scale gauge: (V, R, d, a, r_c) times c with K times c^gamma leaves every sample as it is, so
/// something metric must be known. The sentence that names what is not, or nothing where all is
/// well.
std::optional<PowerRefusal> scale_missing(const PowerKnowledge& known, const PowerSetting& setting);

/// Samples with finite time and power, times relative to the reference.
struct PowerSamples {
  std::vector<double> time_s, power_w;
  std::vector<double> weight;  ///< 1 / sigma^2; all 1 where the noise is not known
  bool noise_known = false;
  std::int64_t outside = 0;
};

/// Checks the problem and gathers its samples. Refuses by name: too_few_samples, no_time_spread,
/// below_noise (no sample is positive), unobservable (by the gauge). Throws std::invalid_argument
/// for spans of different length, std::domain_error for a sigma, K, gamma or r_c that is not
/// positive.
std::variant<PowerSamples, PowerRefusal> gather(const PowerProblem& problem);

/// Inverts an information matrix over `free`, scaled to unit diagonal. Refuses (unobservable) and
/// names the parameters that cannot be told apart where it is singular.
std::variant<Eigen::MatrixXd, PowerRefusal> invert_information(
    const Eigen::MatrixXd& information, std::span<const PowerParameter> free);

/// Covariance over `free` spread into the full matrix.
PowerMatrix spread_covariance(const Eigen::MatrixXd& covariance,
                              std::span<const PowerParameter> free);

}  // namespace vildar
