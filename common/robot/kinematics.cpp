#include <cmath>

#include "common/core/error.h"
#include "common/robot/names.h"
#include "common/robot/robot_impl.h"

namespace periplus::robot {

namespace {
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct MjDataDeleter {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
}  // namespace

struct Kinematics::Data {
  std::shared_ptr<const RobotModel> model;
  std::unique_ptr<mjData, MjDataDeleter> mj;
  Eigen::VectorXd q;

  const mjModel* m() const { return model->impl().mj.get(); }

  int body(const std::string& link) const {
    const auto& bodies = model->impl().bodies;
    const auto it = bodies.find(link);
    if (it != bodies.end()) return it->second;
    std::vector<std::string> names;
    for (const auto& entry : bodies) names.push_back(entry.first);
    throw_error(ErrorCode::bad_input, unknown_name("link", link, names));
  }
  Pose pose(int b) const {
    return make_pose(Eigen::Vector3d::Map(mj->xpos + 3 * b), Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(mj->xmat + 9 * b));
  }
  Eigen::MatrixXd jacobian(int b, const Eigen::Vector3d& p_W) const {
    RowMatrix J(6, m()->nv);
    mj_jac(m(), mj.get(), J.data(), J.data() + 3 * m()->nv, p_W.data(), b);
    return J;
  }
};

Kinematics::Kinematics(std::shared_ptr<const RobotModel> model) : data_(std::make_unique<Data>()) {
  data_->model = std::move(model);
  data_->mj.reset(mj_makeData(data_->m()));
  require(data_->mj != nullptr, ErrorCode::internal, "MuJoCo has no memory for the robot's state");
  set(data_->model->half_sitting());
}
Kinematics::~Kinematics() = default;

const RobotModel& Kinematics::model() const { return *data_->model; }
const Eigen::VectorXd& Kinematics::q() const { return data_->q; }

void Kinematics::set(const Eigen::VectorXd& q) {
  const int n = data_->model->dof();
  if (q.size() != n) {
    throw_error(ErrorCode::bad_size, "a configuration of robot '" + data_->model->name() + "' has " + std::to_string(n) + " numbers, not " +
                                         std::to_string(q.size()));
  }
  require(q.allFinite(), ErrorCode::not_finite, "a configuration holds a number that is not finite");
  data_->q = q;
  mju_copy(data_->mj->qpos, q.data(), n);
  mj_kinematics(data_->m(), data_->mj.get());
  mj_comPos(data_->m(), data_->mj.get());
}

Pose Kinematics::X_WL(const std::string& link) const { return data_->pose(data_->body(link)); }

Pose Kinematics::X_WC(const std::string& camera) const {
  const Camera& c = data_->model->camera(camera);
  return X_WL(c.link) * c.X_LC;
}

Pose Kinematics::X_WS_left() const {
  const Foot& foot = data_->model->left_foot();
  return X_WL(foot.link) * foot.X_LS;
}

Pose Kinematics::X_WS_right() const {
  const Foot& foot = data_->model->right_foot();
  return X_WL(foot.link) * foot.X_LS;
}

Eigen::MatrixXd Kinematics::jacobian(const std::string& link, const Eigen::Vector3d& p_L) const {
  const int b = data_->body(link);
  return data_->jacobian(b, data_->pose(b) * p_L);
}

Eigen::MatrixXd Kinematics::jacobian_camera(const std::string& camera) const {
  const Camera& c = data_->model->camera(camera);
  return jacobian(c.link, c.X_LC.translation());
}

Eigen::MatrixXd Kinematics::jacobian_sole(bool left) const {
  const Foot& foot = left ? data_->model->left_foot() : data_->model->right_foot();
  return jacobian(foot.link, foot.X_LS.translation());
}

Eigen::Vector3d Kinematics::center_of_mass() const { return Eigen::Vector3d::Map(data_->mj->subtree_com); }

Eigen::MatrixXd Kinematics::jacobian_center_of_mass() const {
  RowMatrix J(3, data_->m()->nv);
  mj_jacSubtreeCom(data_->m(), data_->mj.get(), J.data(), 0);
  return J;
}

Eigen::VectorXd Kinematics::gravity() const {
  // Velocities stay zero, so the recursive Newton-Euler bias is gravity alone.
  Eigen::VectorXd g(data_->m()->nv);
  mj_rne(data_->m(), data_->mj.get(), 0, g.data());
  return g;
}

void Kinematics::capsule(int i, Eigen::Vector3d& a, Eigen::Vector3d& b) const {
  const Capsule& c = data_->model->capsules().at(static_cast<std::size_t>(i));
  const Pose X = X_WL(c.link);
  a = X * c.a;
  b = X * c.b;
}

}  // namespace periplus::robot
