#include "calib/site/joint_solve.h"

#include <array>
#include <cmath>
#include <memory>

#include <ceres/ceres.h>

#include "estimate/geometry_cost.h"
#include "estimate/solve.h"

namespace vildar {
namespace {

// A pass's distance from the means of its populations, in their spreads.
struct PopulationResidual {
  const Pass* pass;
  const std::vector<Population>* populations;

  template <class T>
  bool operator()(T const* const* blocks, T* residual) const {
    for (std::size_t i = 0; i < pass->members.size(); ++i) {
      const Membership& member = pass->members[i];
      const Population& population = (*populations)[member.population];
      residual[i] = (shared_value(population.kind, blocks[0]) - blocks[1][member.population]) /
                    std::hypot(population.spread, member.extra_std);
    }
    return true;
  }
};

struct MeanPrior {
  const std::vector<Population>* populations;

  template <class T>
  bool operator()(T const* const* blocks, T* residual) const {
    for (std::size_t i = 0; i < populations->size(); ++i) {
      const Uncertain& mean = (*populations)[i].mean;
      residual[i] = (blocks[0][i] - mean.mean) / mean.std;
    }
    return true;
  }
};

using PathJet = ceres::Jet<double, kPathParameters>;

}  // namespace

bool solve_jointly(std::span<Pass> passes, std::vector<Population>& populations) {
  std::vector<double> means;
  for (const Population& population : populations) means.push_back(population.present);
  const auto count = static_cast<int>(means.size());
  ceres::HuberLoss loss(kHuberBound), apart_loss(kApartBound);
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (Pass& pass : passes) {
    add_geometry(pass.problem, pass.path.data(), pass.free, &loss, &apart_loss, problem);
    auto* cost = new ceres::DynamicAutoDiffCostFunction<PopulationResidual>(
        new PopulationResidual{&pass, &populations});
    cost->AddParameterBlock(kPathParameters);
    cost->AddParameterBlock(count);
    cost->SetNumResiduals(static_cast<int>(pass.members.size()));
    problem.AddResidualBlock(cost, nullptr, pass.path.data(), means.data());
    ordering->AddElementToGroup(pass.path.data(), 0);
  }
  auto* prior = new ceres::DynamicAutoDiffCostFunction<MeanPrior>(new MeanPrior{&populations});
  prior->AddParameterBlock(count);
  prior->SetNumResiduals(count);
  problem.AddResidualBlock(prior, nullptr, means.data());
  ordering->AddElementToGroup(means.data(), 1);

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = 50;
  solver.function_tolerance = 1e-9;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (std::size_t i = 0; i < populations.size(); ++i) populations[i].present = means[i];
  return summary.IsSolutionUsable();
}

LinearPass linearise(const Pass& pass, const std::vector<Population>& populations) {
  std::array<PathJet, kPathParameters> path;
  for (int i = 0; i < kPathParameters; ++i)
    path[static_cast<std::size_t>(i)] = PathJet(pass.path[i], i);
  LinearPass linear;
  linear.members = pass.members;
  const auto n = static_cast<Eigen::Index>(pass.free.size());
  const auto residuals = geometry_residuals(pass.problem, pass.path, pass.free, Slopes::of_path);
  linear.information = residuals ? residuals->information() : Eigen::MatrixXd::Zero(n, n);
  linear.gradient = residuals ? residuals->gradient() : Eigen::VectorXd::Zero(n);
  const auto count = static_cast<Eigen::Index>(pass.members.size());
  linear.shared.resize(count);
  linear.shared_by_path.resize(count, n);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Membership& member = pass.members[static_cast<std::size_t>(i)];
    const PathJet value = shared_value(populations[member.population].kind, path.data());
    linear.shared[i] = value.a;
    linear.shared_by_path.row(i) = PathVector(value.v)(pass.free).transpose();
  }
  return linear;
}

}  // namespace vildar
