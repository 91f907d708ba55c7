#include "services/posture_generator/posture_problem.h"

#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "common/robot/capsule_distance.h"

namespace periplus::posture {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kUnbounded = 1e20;
// Rows of the constraint vector.
constexpr int kCameraRows = 7;                    // position 3, orientation 3, not flipped 1
constexpr int kFeetRows = 13;                     // two soles 3 each, equilibrium 2, stance 5
constexpr int kFirstDistance = kCameraRows + kFeetRows;

Matrix3d skew(const Vector3d& v) {
  Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Vector2d turn_left(const Vector2d& v) { return {-v.y(), v.x()}; }

}  // namespace

RobotFacts::RobotFacts(std::shared_ptr<const robot::RobotModel> robot, const Settings& settings)
    : robot_(std::move(robot)), settings_(settings), half_sitting_(robot_->half_sitting()) {
  for (const robot::Capsule& capsule : robot_->capsules()) capsule_links_.push_back(link_number(capsule.link));
  left_foot_link_ = link_number(robot_->left_foot().link);
  right_foot_link_ = link_number(robot_->right_foot().link);
  camera_link_ = link_number(robot_->camera("left").link);

  // A joint moves a link where its column of the Jacobian is not zero.
  robot::Kinematics kinematics(robot_);
  kinematics.set(half_sitting_);
  std::vector<std::vector<char>> moved_by;
  for (const std::string& link : links_) {
    const Eigen::MatrixXd J = kinematics.jacobian(link);
    std::vector<char> moves;
    for (Eigen::Index i = 0; i < J.cols(); ++i) moves.push_back(J.col(i).tail<3>().norm() + J.col(i).head<3>().norm() > 1e-9 ? 1 : 0);
    moved_by.push_back(std::move(moves));
  }
  for (int i = 0; i < robot_->dof(); ++i) {
    if (i < 6 || moved_by[left_foot_link_][i] != 0 || moved_by[right_foot_link_][i] != 0 || moved_by[camera_link_][i] != 0) free_.push_back(i);
  }
  find_pairs(moved_by);
}

int RobotFacts::link_number(const std::string& name) {
  const auto it = std::find(links_.begin(), links_.end(), name);
  if (it != links_.end()) return static_cast<int>(it - links_.begin());
  links_.push_back(name);
  return static_cast<int>(links_.size()) - 1;
}

void RobotFacts::find_pairs(const std::vector<std::vector<char>>& moved_by) {
  constexpr int kSamples = 2000;
  constexpr double kNear = 0.06;  // [m] beyond the least distance
  std::vector<std::pair<int, int>> candidates;
  for (const auto& [i, j] : robot_->self_collision_pairs()) {
    const auto &a = moved_by[capsule_links_[i]], &b = moved_by[capsule_links_[j]];
    if (std::any_of(free_.begin(), free_.end(), [&](int k) { return a[k] != b[k]; })) candidates.emplace_back(i, j);
  }
  std::vector<char> near(candidates.size(), 0);
  robot::Kinematics kinematics(robot_);
  Random random(1);
  const auto& capsules = robot_->capsules();
  std::vector<std::pair<Vector3d, Vector3d>> ends(capsules.size());
  for (int sample = 0; sample < kSamples; ++sample) {
    Eigen::VectorXd q = half_sitting_;
    for (const int k : free_) {
      if (k >= 6) q[k] = random.uniform(robot_->joints()[k - 6].posture_lower, robot_->joints()[k - 6].posture_upper);
    }
    kinematics.set(q);
    for (std::size_t i = 0; i < capsules.size(); ++i) kinematics.capsule(static_cast<int>(i), ends[i].first, ends[i].second);
    for (std::size_t p = 0; p < candidates.size(); ++p) {
      if (near[p] != 0) continue;
      const auto [i, j] = candidates[p];
      const double distance = robot::closest_points(ends[i].first, ends[i].second, ends[j].first, ends[j].second).distance;
      near[p] = distance - capsules[i].radius - capsules[j].radius < settings_.self_distance + kNear ? 1 : 0;
    }
  }
  for (std::size_t p = 0; p < candidates.size(); ++p) {
    if (near[p] != 0) pairs_.push_back(candidates[p]);
  }
}

PostureProblem::PostureProblem(const RobotFacts& facts, const Surroundings& surroundings, const Pose& X_WC)
    : facts_(facts), surroundings_(surroundings), X_WC_(X_WC), kinematics_(facts.robot()) {
  const Settings& s = facts_.settings();
  const auto& free = facts_.free();
  const auto n = static_cast<Eigen::Index>(free.size());
  variable_bounds_ = {Eigen::VectorXd::Constant(n, -kUnbounded), Eigen::VectorXd::Constant(n, kUnbounded)};
  const auto bound = [&](Eigen::Index i, double lower, double upper) {
    variable_bounds_.lower[i] = lower;
    variable_bounds_.upper[i] = upper;
  };
  const double z = facts_.half_sitting()[2];
  bound(2, z - s.base_lower, z + s.base_rise);
  bound(4, s.base_pitch_min, s.base_pitch_max);
  bound(5, -s.base_roll, s.base_roll);
  for (Eigen::Index i = 6; i < n; ++i) {
    const robot::Joint& joint = facts_.robot()->joints()[free[i] - 6];
    bound(i, joint.posture_lower, joint.posture_upper);
  }

  for (int i = 0; i < 6; ++i) add_bound(0, 0);
  add_bound(0.3, kUnbounded);                                                   // not the flipped solution
  for (int i = 0; i < 6; ++i) add_bound(0, 0);                                  // soles
  add_bound(-s.equilibrium_distance, s.equilibrium_distance);
  add_bound(s.equilibrium_share, 1 - s.equilibrium_share);
  add_bound(-s.stance_x, s.stance_x);
  add_bound(s.stance_y_min, s.stance_y_max);
  add_bound(-s.stance_x, s.stance_x);
  add_bound(s.stance_y_min, s.stance_y_max);
  add_bound(-std::sin(s.stance_yaw_in), std::sin(s.stance_yaw_out));
  for (std::size_t i = 0; i < facts_.pairs().size(); ++i) add_bound(s.self_distance, kUnbounded);
  const std::size_t capsules = facts_.robot()->capsules().size();
  if (surroundings_.collision != nullptr) {
    for (std::size_t i = 0; i < capsules; ++i) add_bound(s.scene_distance, kUnbounded);
  }
  if (surroundings_.object != nullptr) {
    for (std::size_t i = 0; i < capsules; ++i) add_bound(s.object_distance, kUnbounded);
  }
  g_ = Eigen::VectorXd::Zero(constraint_bounds_.lower.size());
  J_ = RowMatrix::Zero(g_.size(), n);
  link_jacobians_.resize(facts_.links().size());
  link_origins_.resize(facts_.links().size());
}

void PostureProblem::add_bound(double lower, double upper) {
  const Eigen::Index i = constraint_bounds_.lower.size();
  constraint_bounds_.lower.conservativeResize(i + 1);
  constraint_bounds_.upper.conservativeResize(i + 1);
  constraint_bounds_.lower[i] = lower;
  constraint_bounds_.upper[i] = upper;
}

Eigen::VectorXd PostureProblem::configuration(const Eigen::VectorXd& x) const {
  Eigen::VectorXd q = facts_.half_sitting();
  for (std::size_t i = 0; i < facts_.free().size(); ++i) q[facts_.free()[i]] = x[static_cast<Eigen::Index>(i)];
  return q;
}

Eigen::VectorXd PostureProblem::variables(const Eigen::VectorXd& q) const {
  Eigen::VectorXd x(static_cast<Eigen::Index>(facts_.free().size()));
  for (std::size_t i = 0; i < facts_.free().size(); ++i) x[static_cast<Eigen::Index>(i)] = q[facts_.free()[i]];
  return x;
}

// Close to half-sitting; where the robot stands and looks is free.
double PostureProblem::objective(const Eigen::VectorXd& x) {
  Eigen::VectorXd difference = x - variables(facts_.half_sitting());
  difference.head<4>().setZero();
  return 0.5 * difference.squaredNorm();
}

Eigen::VectorXd PostureProblem::objective_gradient(const Eigen::VectorXd& x) {
  Eigen::VectorXd difference = x - variables(facts_.half_sitting());
  difference.head<4>().setZero();
  return difference;
}

const Eigen::VectorXd& PostureProblem::constraints(const Eigen::VectorXd& x) {
  update(x, false);
  return g_;
}

const RowMatrix& PostureProblem::constraint_jacobian(const Eigen::VectorXd& x) {
  update(x, true);
  return J_;
}

void PostureProblem::update(const Eigen::VectorXd& x, bool with_jacobian) {
  if (has_values_ && x == x_ && (has_jacobian_ || !with_jacobian)) return;
  x_ = x;
  has_values_ = true;
  has_jacobian_ = with_jacobian;
  kinematics_.set(configuration(x));
  for (std::size_t l = 0; l < facts_.links().size(); ++l) {
    link_origins_[l] = kinematics_.X_WL(facts_.links()[l]).translation();
    if (with_jacobian) link_jacobians_[l] = kinematics_.jacobian(facts_.links()[l])(Eigen::all, facts_.free());
  }
  if (with_jacobian) J_.setZero();
  camera_rows(with_jacobian);
  feet_rows(with_jacobian);
  distance_rows(with_jacobian);
}

RowMatrix PostureProblem::point_jacobian(int link, const Vector3d& p_W) const {
  const RowMatrix& J = link_jacobians_[link];
  return J.topRows<3>() - skew(p_W - link_origins_[link]) * J.bottomRows<3>();
}

void PostureProblem::camera_rows(bool with_jacobian) {
  const Pose X = kinematics_.X_WC("left");
  const Matrix3d R = X.linear(), T = X_WC_.linear();
  // Half the sum of r_i x t_i is sin(angle) times the axis of the rotation that is left; it also vanishes at 180
  // degrees, which the last row excludes.
  g_.segment<3>(0) = X.translation() - X_WC_.translation();
  g_.segment<3>(3) = 0.5 * (R.col(0).cross(T.col(0)) + R.col(1).cross(T.col(1)) + R.col(2).cross(T.col(2)));
  g_[6] = 0.5 * ((R * T.transpose()).trace() - 1);  // cosine of that angle
  if (!with_jacobian) return;
  const RowMatrix& J = link_jacobians_[facts_.camera_link()];
  J_.topRows<3>() = point_jacobian(facts_.camera_link(), X.translation());
  J_.middleRows<3>(3) = 0.5 * (R * T.transpose() - (R * T.transpose()).trace() * Matrix3d::Identity()) * J.bottomRows<3>();
  J_.row(6) = g_.segment<3>(3).transpose() * J.bottomRows<3>();
}

void PostureProblem::feet_rows(bool with_jacobian) {
  const Pose soles[2] = {kinematics_.X_WS_left(), kinematics_.X_WS_right()};
  const int links[2] = {facts_.left_foot_link(), facts_.right_foot_link()};
  RowMatrix J_sole[2], J_heading[2];
  Vector2d p[2], heading[2];
  int row = kCameraRows;
  for (int f = 0; f < 2; ++f) {
    const Vector3d up = soles[f].linear().col(2), forward = soles[f].linear().col(0);
    p[f] = soles[f].translation().head<2>();
    heading[f] = forward.head<2>();
    g_.segment<3>(row) << soles[f].translation().z(), up.x(), up.y();
    if (with_jacobian) {
      const RowMatrix J = point_jacobian(links[f], soles[f].translation());
      const auto turning = link_jacobians_[links[f]].bottomRows<3>();
      J_sole[f] = J.topRows<2>();
      J_heading[f] = (-skew(forward) * turning).topRows<2>();
      J_.row(row) = J.row(2);
      J_.middleRows<2>(row + 1) = (-skew(up) * turning).topRows<2>();
    }
    row += 3;
  }

  // Centre of mass: distance from the line through the feet, and share of the way from the left to the right foot.
  const Vector2d along = p[1] - p[0], com = kinematics_.center_of_mass().head<2>() - p[0];
  const double length = along.norm(), length2 = along.squaredNorm();
  const double cross = along.x() * com.y() - along.y() * com.x(), dot = along.dot(com);
  g_[row] = cross / length;
  g_[row + 1] = dot / length2;
  if (with_jacobian) {
    const RowMatrix J_com = kinematics_.jacobian_center_of_mass()(Eigen::seq(0, 1), facts_.free()) - J_sole[0];
    const RowMatrix J_along = J_sole[1] - J_sole[0];
    const RowMatrix J_length = along.transpose() / length * J_along;
    const RowMatrix J_cross = turn_left(along).transpose() * J_com - turn_left(com).transpose() * J_along;
    J_.row(row) = J_cross / length - cross / length2 * J_length;
    J_.row(row + 1) = (com.transpose() * J_along + along.transpose() * J_com) / length2 - 2 * dot / (length2 * length) * J_length;
  }
  row += 2;

  // Stance: the left foot seen from the right one, then the right foot from the left one (y counted to the right).
  for (int f = 1; f >= 0; --f) {
    const double side = f == 1 ? 1 : -1;
    const Vector2d to_other = p[1 - f] - p[f], left = turn_left(heading[f]);
    g_[row] = heading[f].dot(to_other);
    g_[row + 1] = side * left.dot(to_other);
    if (with_jacobian) {
      const RowMatrix J_other = J_sole[1 - f] - J_sole[f];
      J_.row(row) = heading[f].transpose() * J_other + to_other.transpose() * J_heading[f];
      J_.row(row + 1) = side * (left.transpose() * J_other - turn_left(to_other).transpose() * J_heading[f]);
    }
    row += 2;
  }
  // Sine of the angle from the right foot's heading to the left one's.
  g_[row] = turn_left(heading[1]).dot(heading[0]);
  if (with_jacobian) {
    J_.row(row) = turn_left(heading[1]).transpose() * J_heading[0] - turn_left(heading[0]).transpose() * J_heading[1];
  }
}

void PostureProblem::distance_rows(bool with_jacobian) {
  const auto& capsules = facts_.robot()->capsules();
  const double range = facts_.settings().distance_range;
  std::vector<std::pair<Vector3d, Vector3d>> ends(capsules.size());
  for (std::size_t i = 0; i < capsules.size(); ++i) kinematics_.capsule(static_cast<int>(i), ends[i].first, ends[i].second);
  const auto& links = facts_.capsule_links();
  int row = kFirstDistance;
  for (const auto& [i, j] : facts_.pairs()) {
    const robot::ClosestPoints c = robot::closest_points(ends[i].first, ends[i].second, ends[j].first, ends[j].second);
    g_[row] = c.distance - capsules[i].radius - capsules[j].radius;
    if (with_jacobian && c.distance > 1e-9) {
      const Vector3d n = (c.on_first - c.on_second) / c.distance;
      J_.row(row) = n.transpose() * (point_jacobian(links[i], c.on_first) - point_jacobian(links[j], c.on_second));
    }
    ++row;
  }
  if (surroundings_.collision != nullptr) {
    for (std::size_t i = 0; i < capsules.size(); ++i, ++row) {
      const double reach = range + capsules[i].radius;
      const scene::Closest c = surroundings_.collision->capsule_distance(ends[i].first, ends[i].second, 0, reach);
      g_[row] = c.distance - capsules[i].radius;
      if (with_jacobian && c.distance < reach && std::abs(c.distance) > 1e-9) {
        const Vector3d n = (c.on_shape - c.on_solid) / c.distance;
        J_.row(row) = n.transpose() * point_jacobian(links[i], c.on_shape);
      }
    }
  }
  if (surroundings_.object != nullptr) {
    for (std::size_t i = 0; i < capsules.size(); ++i, ++row) {
      const double reach = range + capsules[i].radius;
      const ObjectObstacle::Nearest c = surroundings_.object->nearest(ends[i].first, ends[i].second, reach);
      g_[row] = c.distance - capsules[i].radius;
      const Vector3d away = c.on_axis - c.center;
      if (with_jacobian && c.distance < reach && away.norm() > 1e-9) {
        J_.row(row) = away.normalized().transpose() * point_jacobian(links[i], c.on_axis);
      }
    }
  }
}

std::string PostureProblem::constraint_name(const Eigen::VectorXd& x, int i) {
  if (i < kCameraRows) return "camera_pose";
  if (i < kCameraRows + 6) return "feet_on_floor";
  if (i < kCameraRows + 8) return "equilibrium";
  if (i < kFirstDistance) return "stance";
  const auto& capsules = facts_.robot()->capsules();
  int k = i - kFirstDistance;
  const int pairs = static_cast<int>(facts_.pairs().size());
  if (k < pairs) return "self_collision:" + capsules[facts_.pairs()[k].first].name + "-" + capsules[facts_.pairs()[k].second].name;
  k -= pairs;
  if (surroundings_.collision != nullptr) {
    if (k < static_cast<int>(capsules.size())) {
      kinematics_.set(configuration(x));
      has_values_ = false;
      Vector3d a, b;
      kinematics_.capsule(k, a, b);
      const int solid = surroundings_.collision->capsule_distance(a, b, capsules[k].radius, facts_.settings().distance_range).solid;
      const bool named = surroundings_.scene != nullptr && solid >= 0 && solid < static_cast<int>(surroundings_.scene->solids.size());
      return "scene_collision:" + (named ? surroundings_.scene->solids[solid].name : std::string("room"));
    }
  }
  return "object_collision";
}

}  // namespace periplus::posture
