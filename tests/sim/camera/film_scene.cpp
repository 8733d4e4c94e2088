#include "tests/sim/camera/film_scene.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/random.h"

namespace gaitcam {

cv::Mat SpeckleTexture(int size_px, uint64_t seed) {
  RandomStream random(seed, "speckle");
  cv::Mat fine(size_px, size_px, CV_32FC3), coarse(size_px / 8, size_px / 8, CV_32FC3);
  for (cv::Mat* noise : {&fine, &coarse}) {
    for (int i = 0; i < int(noise->total()) * 3; ++i) noise->ptr<float>()[i] = float(random.Uniform());
  }
  cv::resize(coarse, coarse, fine.size(), 0, 0, cv::INTER_CUBIC);
  cv::GaussianBlur(fine, fine, cv::Size(0, 0), 1.5);
  const cv::Scalar half = cv::Scalar::all(0.5);
  cv::Mat sum, texture;
  cv::addWeighted(fine - half, 3.0, coarse - half, 0.7, 0, sum);
  sum += half;
  sum.convertTo(texture, CV_8UC3, 255);
  return texture;
}

MjModelPtr FlyerModel(const std::string& worldbody, const std::string& assets,
                      std::vector<std::pair<std::string, std::vector<unsigned char>>> files,
                      const std::string& on_flyer) {
  MjcfBundle bundle;
  bundle.xml = R"(<mujoco><option gravity="0 0 0"/><statistic extent="5"/>
    <visual><headlight active="1" ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
    <asset>)" + assets +
               R"(</asset><worldbody>)" + worldbody +
               R"(<body name="flyer"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <camera name="camera.left" xyaxes="1 0 0 0 -1 0" fovy="45"/>)" +
               on_flyer + "</body></worldbody></mujoco>";
  bundle.files = std::move(files);
  return CompileMjcf(bundle, "test scene");
}

MjModelPtr SpeckledRoom() {
  std::vector<std::pair<std::string, std::vector<unsigned char>>> files;
  std::string assets;
  for (int i = 0; i < 4; ++i) {
    const std::string n = std::to_string(i);
    files.push_back(PngFile("speckle" + n + ".png", SpeckleTexture(512, uint64_t(i))));
    assets += "<texture name='t" + n + "' type='2d' file='speckle" + n + ".png'/><material name='m" + n +
              "' texture='t" + n + "' texrepeat='" + (i == 0 ? "3 3" : "1 1") + "' specular='0'/>";
  }
  const std::string worldbody = R"(
    <geom type="plane" size="2 2 0.1" material="m0"/>
    <geom type="box" pos="2 0 1" zaxis="-1 0 0" size="1 2 0.01" material="m1"/>
    <geom type="box" pos="0 2 1" zaxis="0 -1 0" size="2 1 0.01" material="m2"/>
    <geom type="box" pos="0 -2 1" zaxis="0 1 0" size="2 1 0.01" material="m3"/>
    <geom type="box" pos="1 0.3 0.15" size="0.1 0.1 0.15" material="m2"/>
    <geom type="box" pos="1.3 -0.4 0.2" size="0.15 0.1 0.2" material="m1"/>)";
  return FlyerModel(worldbody, assets, std::move(files));
}

MotionRecord RecordFlight(const mjModel* model, const Flight& flight, double begin_s, double end_s) {
  constexpr double kStep = 0.002;
  MotionRecord record;
  const auto qpos = [&](double t) {
    const Pose X = flight(t);
    const Eigen::Quaterniond& q = X.rotation;
    return std::vector<double>{X.translation.x(), X.translation.y(), X.translation.z(), q.w(), q.x(), q.y(), q.z()};
  };
  std::vector<double> before = qpos(begin_s), velocity(6, 0);
  record.Append({int64_t(std::llround(begin_s * 1e9)), before, velocity});
  for (int i = 1; begin_s + (i - 1) * kStep < end_s; ++i) {
    std::vector<double> now = qpos(begin_s + i * kStep);
    mj_differentiatePos(model, velocity.data(), kStep, before.data(), now.data());
    record.Append({int64_t(std::llround((begin_s + i * kStep) * 1e9)), now, velocity});
    before = std::move(now);
  }
  return record;
}

Flight ConstantTwist(const Pose& X_WC, const Eigen::Vector3d& v, const Eigen::Vector3d& w) {
  return [=](double t) {
    const double angle = w.norm() * t;
    const Eigen::Vector3d axis = w.norm() > 0 ? Eigen::Vector3d(w.normalized()) : Eigen::Vector3d::UnitZ();
    // The translation is along a straight line in the frame at time 0: simple, and what a chord of any path looks like.
    return X_WC * Pose(Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)), Eigen::Vector3d(v * t));
  };
}

SceneInstant PlaceFlyer(const mjModel* model, mjData* data, const Pose& X_WC) {
  const Eigen::Quaterniond& q = X_WC.rotation;
  const double qpos[] = {X_WC.translation.x(), X_WC.translation.y(), X_WC.translation.z(), q.w(), q.x(), q.y(), q.z()};
  std::copy(qpos, qpos + 7, data->qpos);
  mj_kinematics(model, data);
  mj_comPos(model, data);
  mj_camlight(model, data);
  return CaptureInstant(model, *data, FindCamera(model, "camera.left"), 0);
}

Pose LookingAlongX(const Eigen::Vector3d& position) {
  Eigen::Matrix3d R;
  R.col(0) = Eigen::Vector3d(0, -1, 0);
  R.col(1) = Eigen::Vector3d(0, 0, -1);
  R.col(2) = Eigen::Vector3d(1, 0, 0);
  return {R, position};
}

}  // namespace gaitcam
