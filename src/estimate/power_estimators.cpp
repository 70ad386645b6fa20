#include "estimate/power_estimators.h"

namespace vildar {

std::string_view name_of(PowerMethod method) {
  switch (method) {
    case PowerMethod::paper_ls: return "paper_ls";
    case PowerMethod::weighted_ls: return "weighted_ls";
    case PowerMethod::max_likelihood: return "max_likelihood";
    case PowerMethod::huber: return "huber";
    case PowerMethod::ceres: return "ceres";
    case PowerMethod::kalman: return "kalman";
  }
  return "";
}

PowerOutcome estimate_power(const PowerProblem& problem, PowerMethod method) {
  switch (method) {
    case PowerMethod::paper_ls: return estimate_paper_ls(problem);
    case PowerMethod::weighted_ls: return estimate_weighted_ls(problem);
    case PowerMethod::max_likelihood: return estimate_max_likelihood(problem);
    case PowerMethod::huber: return estimate_huber(problem);
    case PowerMethod::ceres: return estimate_ceres(problem);
    case PowerMethod::kalman: return estimate_kalman(problem);
  }
  return PowerRefusal{Miss::unobservable, "no such method"};
}

}  // namespace vildar
