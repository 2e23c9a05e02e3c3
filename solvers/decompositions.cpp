#include "solvers/decompositions.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

// LAPACK and the runtime of OpenMP, whose headers are in packages that nothing else here needs.
extern "C" {
void dgesdd_(const char* job, const int* rows, const int* columns, double* a, const int* stride,
             double* values, double* u, const int* u_stride, double* vt, const int* vt_stride,
             double* work, const int* work_size, int* integers, int* info);
void dsyevd_(const char* job, const char* triangle, const int* size, double* a, const int* stride,
             double* values, double* work, const int* work_size, int* integers,
             const int* integers_size, int* info);
int omp_get_max_threads();
void omp_set_num_threads(int);
}

namespace ertbench {
namespace {

/// OpenBLAS starts a thread for each core otherwise, beside those that a run has shared out.
class OneBlasThread {
 public:
  OneBlasThread() : before_(omp_get_max_threads()) { omp_set_num_threads(1); }
  ~OneBlasThread() { omp_set_num_threads(before_); }
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  int before_;
};

void require_success(int info) {
  if (info != 0) throw std::runtime_error("a decomposition of a matrix did not converge");
}

}  // namespace

DenseSvd dense_svd(const Eigen::MatrixXd& matrix) {
  const int rows = static_cast<int>(matrix.rows());
  const int columns = static_cast<int>(matrix.cols());
  const int least = std::min(rows, columns);
  DenseSvd svd{Eigen::MatrixXd(rows, least), Eigen::VectorXd(least), {}};
  Eigen::MatrixXd a = matrix;
  Eigen::MatrixXd vt(least, columns);
  std::vector<int> integers(8 * static_cast<std::size_t>(least) + 1);
  const int stride = std::max(1, rows);
  const int vt_stride = std::max(1, least);
  const OneBlasThread one;
  int info = 0;
  const auto call = [&](double* work, int size) {
    dgesdd_("S", &rows, &columns, a.data(), &stride, svd.values.data(), svd.left.data(), &stride,
            vt.data(), &vt_stride, work, &size, integers.data(), &info);
    require_success(info);
  };
  double wanted = 0;
  call(&wanted, -1);
  std::vector<double> work(static_cast<std::size_t>(wanted) + 1);
  call(work.data(), static_cast<int>(wanted));
  svd.right = vt.transpose();
  return svd;
}

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix) {
  const int size = static_cast<int>(matrix.rows());
  SymmetricEigen eigen{Eigen::VectorXd(size), matrix};
  const int stride = std::max(1, size);
  const OneBlasThread one;
  int info = 0;
  const auto call = [&](double* work, int work_size, int* integers, int integers_size) {
    dsyevd_("V", "L", &size, eigen.vectors.data(), &stride, eigen.values.data(), work, &work_size,
            integers, &integers_size, &info);
    require_success(info);
  };
  double wanted = 0;
  int wanted_integers = 0;
  call(&wanted, -1, &wanted_integers, -1);
  std::vector<double> work(static_cast<std::size_t>(wanted) + 1);
  std::vector<int> integers(static_cast<std::size_t>(wanted_integers) + 1);
  call(work.data(), static_cast<int>(wanted), integers.data(), wanted_integers);
  return eigen;
}

}  // namespace ertbench
