// The linear algebra that everything here is written in.
#pragma once

#include <limits>

#include <Eigen/Core>

namespace humanoid_rail {

using Matrix = Eigen::MatrixXd;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;
constexpr double INFINITE = std::numeric_limits<double>::infinity();

}  // namespace humanoid_rail
