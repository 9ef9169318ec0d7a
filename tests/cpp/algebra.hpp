// SPDX-License-Identifier: MIT
/// @file  Dense linear algebra of oracles, compiled once: each decomposition of Eigen, and each product of expressions, costs a
///        test seconds of compilation.
#pragma once
#include <Eigen/Core>
#include <complex>

namespace gyrostat::test {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd times(const MatrixXd& A, const MatrixXd& B);
MatrixXd times(const MatrixXd& A, const MatrixXd& B, const MatrixXd& C);
/// A diag(d).
MatrixXd columns_times(const MatrixXd& A, const VectorXd& d);
VectorXd applied(const MatrixXd& A, const VectorXd& x);
/// A' x.
VectorXd transpose_applied(const MatrixXd& A, const VectorXd& x);
MatrixXd inverse(const MatrixXd& A);
/// x of A x = b.
VectorXd solved(const MatrixXd& A, const VectorXd& b);
/// Of least norm, x with the least |A x - b|.
VectorXd least_squares(const MatrixXd& A, const VectorXd& b);
/// L of L L' = A.
MatrixXd cholesky(const MatrixXd& A);
/// e' P^-1 e.
double normalised_square(const MatrixXd& P, const VectorXd& e);
/// Columns that span what A takes to zero.
MatrixXd kernel(const MatrixXd& A);
/// Largest first.
VectorXd singular_values(const MatrixXd& A);
Eigen::VectorXcd eigenvalues(const MatrixXd& A);
/// Of a symmetric matrix, of which the lower triangle is read; smallest first.
VectorXd symmetric_eigenvalues(const MatrixXd& A);

}  // namespace gyrostat::test
