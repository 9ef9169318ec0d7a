// SPDX-License-Identifier: MIT
#include "algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace gyrostat::test {

MatrixXd times(const MatrixXd& A, const MatrixXd& B) { return A * B; }
MatrixXd times(const MatrixXd& A, const MatrixXd& B, const MatrixXd& C) { return times(times(A, B), C); }
MatrixXd columns_times(const MatrixXd& A, const VectorXd& d) { return A * d.asDiagonal(); }
VectorXd applied(const MatrixXd& A, const VectorXd& x) { return A * x; }
VectorXd transpose_applied(const MatrixXd& A, const VectorXd& x) { return A.transpose() * x; }
MatrixXd inverse(const MatrixXd& A) { return Eigen::PartialPivLU<MatrixXd>(A).inverse(); }
VectorXd solved(const MatrixXd& A, const VectorXd& b) { return Eigen::PartialPivLU<MatrixXd>(A).solve(b); }
VectorXd least_squares(const MatrixXd& A, const VectorXd& b) {
  return Eigen::JacobiSVD<MatrixXd>(A, Eigen::ComputeThinU | Eigen::ComputeThinV).solve(b);
}
MatrixXd cholesky(const MatrixXd& A) { return Eigen::LLT<MatrixXd>(A).matrixL(); }
double normalised_square(const MatrixXd& P, const VectorXd& e) { return e.dot(solved(P, e)); }
MatrixXd kernel(const MatrixXd& A) { return Eigen::FullPivLU<MatrixXd>(A).kernel(); }
VectorXd singular_values(const MatrixXd& A) {
  return Eigen::JacobiSVD<MatrixXd>(A, Eigen::ComputeThinU | Eigen::ComputeThinV).singularValues();
}
Eigen::VectorXcd eigenvalues(const MatrixXd& A) { return Eigen::EigenSolver<MatrixXd>(A, false).eigenvalues(); }
VectorXd symmetric_eigenvalues(const MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace gyrostat::test
