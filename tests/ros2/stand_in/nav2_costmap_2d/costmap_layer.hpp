// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tf2_ros/buffer.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <limits>
#include <memory>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_lifecycle/lifecycle_node.hpp>
#include <string>
#include <utility>
#include <vector>

#include <geometry_msgs/msg/point.hpp>
#include <nav2_costmap_2d/cost_values.hpp>

// The part of nav2_costmap_2d that a layer uses, with the signatures of Lyrical, the narrowest: node_ is of a class
// that hides create_subscription(), and current_ is atomic. Rules of costmap_2d.cpp, layered_costmap.cpp and
// costmap_layer.cpp, written again; cells of a polygon are those with their centre in it.

namespace nav2 {

class LifecycleNode : public rclcpp_lifecycle::LifecycleNode {
 public:
  using rclcpp_lifecycle::LifecycleNode::LifecycleNode;
  using SharedPtr = std::shared_ptr<LifecycleNode>;
  using WeakPtr = std::weak_ptr<LifecycleNode>;
  void create_subscription() = delete;
};

}  // namespace nav2

namespace nav2_costmap_2d {

class Costmap2D {
 public:
  Costmap2D() = default;
  Costmap2D(const Costmap2D&) = default;
  Costmap2D& operator=(const Costmap2D&) = default;
  virtual ~Costmap2D() = default;

  void resizeMap(unsigned int size_x, unsigned int size_y, double resolution, double origin_x, double origin_y) {
    size_x_ = size_x;
    size_y_ = size_y;
    resolution_ = resolution;
    origin_x_ = origin_x;
    origin_y_ = origin_y;
    cells_.resize(std::size_t{size_x} * size_y);
    resetMaps();
  }
  void resetMapToValue(unsigned int x0, unsigned int y0, unsigned int xn, unsigned int yn, unsigned char value) {
    for (unsigned int y{y0}; y < yn; ++y) {
      for (unsigned int x{x0}; x < xn; ++x) setCost(x, y, value);
    }
  }
  [[nodiscard]] unsigned int getIndex(unsigned int mx, unsigned int my) const { return my * size_x_ + mx; }
  [[nodiscard]] unsigned char getCost(unsigned int mx, unsigned int my) const { return cells_.at(getIndex(mx, my)); }
  void setCost(unsigned int mx, unsigned int my, unsigned char cost) { cells_.at(getIndex(mx, my)) = cost; }
  void mapToWorld(unsigned int mx, unsigned int my, double& wx, double& wy) const {
    wx = origin_x_ + (mx + 0.5) * resolution_;
    wy = origin_y_ + (my + 0.5) * resolution_;
  }
  bool worldToMap(double wx, double wy, unsigned int& mx, unsigned int& my) const {
    if (wx < origin_x_ || wy < origin_y_) return false;
    mx = static_cast<unsigned int>((wx - origin_x_) / resolution_);
    my = static_cast<unsigned int>((wy - origin_y_) / resolution_);
    return mx < size_x_ && my < size_y_;
  }
  void worldToMapEnforceBounds(double wx, double wy, int& mx, int& my) const {
    const auto cell = [this](double from, unsigned int size) {
      if (from < 0) return 0;
      if (from > resolution_ * size) return static_cast<int>(size) - 1;
      return static_cast<int>(from / resolution_);
    };
    mx = cell(wx - origin_x_, size_x_);
    my = cell(wy - origin_y_, size_y_);
  }
  virtual void updateOrigin(double origin_x, double origin_y) {
    const int dx{static_cast<int>((origin_x - origin_x_) / resolution_)};
    const int dy{static_cast<int>((origin_y - origin_y_) / resolution_)};
    const Costmap2D before{*this};
    resetMaps();
    origin_x_ += dx * resolution_;
    origin_y_ += dy * resolution_;
    const int nx{static_cast<int>(size_x_)};
    const int ny{static_cast<int>(size_y_)};
    for (int y{std::max(0, -dy)}; y < std::min(ny, ny - dy); ++y) {
      for (int x{std::max(0, -dx)}; x < std::min(nx, nx - dx); ++x) setCost(x, y, before.getCost(x + dx, y + dy));
    }
  }
  bool setConvexPolygonCost(const std::vector<geometry_msgs::msg::Point>& polygon, unsigned char cost) {
    unsigned int mx{0};
    unsigned int my{0};
    for (const auto& corner : polygon) {
      if (!worldToMap(corner.x, corner.y, mx, my)) return false;
    }
    for (my = 0; my < size_y_; ++my) {
      for (mx = 0; mx < size_x_; ++mx) {
        double x{0};
        double y{0};
        mapToWorld(mx, my, x, y);
        bool is_inside{polygon.size() > 2};
        for (std::size_t i{0}; i < polygon.size(); ++i) {
          const auto& a{polygon[i]};
          const auto& b{polygon[(i + 1) % polygon.size()]};
          is_inside = is_inside && (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x) >= 0;
        }
        if (is_inside) setCost(mx, my, cost);
      }
    }
    return true;
  }
  [[nodiscard]] unsigned char* getCharMap() { return cells_.data(); }
  [[nodiscard]] unsigned int getSizeInCellsX() const { return size_x_; }
  [[nodiscard]] unsigned int getSizeInCellsY() const { return size_y_; }
  [[nodiscard]] double getSizeInMetersX() const { return size_x_ * resolution_; }
  [[nodiscard]] double getSizeInMetersY() const { return size_y_ * resolution_; }
  [[nodiscard]] double getOriginX() const { return origin_x_; }
  [[nodiscard]] double getOriginY() const { return origin_y_; }
  [[nodiscard]] double getResolution() const { return resolution_; }
  void setDefaultValue(unsigned char cost) { default_value_ = cost; }
  [[nodiscard]] unsigned char getDefaultValue() const { return default_value_; }

 protected:
  virtual void resetMaps() {
    std::ranges::fill(cells_, default_value_);
    costmap_ = cells_.data();
  }

  unsigned int size_x_{0};
  unsigned int size_y_{0};
  double resolution_{0};
  double origin_x_{0};
  double origin_y_{0};
  unsigned char* costmap_{nullptr};
  unsigned char default_value_{0};

 private:
  std::vector<unsigned char> cells_;
};

class LayeredCostmap;

class Layer {
 public:
  virtual ~Layer() = default;
  void initialize(LayeredCostmap* parent, std::string name, tf2_ros::Buffer* tf,
                  const nav2::LifecycleNode::WeakPtr& node) {
    layered_costmap_ = parent;
    name_ = std::move(name);
    tf_ = tf;
    node_ = node;
    clock_ = node.lock()->get_clock();
    onInitialize();
  }
  virtual void reset() = 0;
  virtual bool isClearable() = 0;
  virtual void updateBounds(double robot_x, double robot_y, double robot_yaw, double* min_x, double* min_y,
                            double* max_x, double* max_y) = 0;
  virtual void updateCosts(Costmap2D& master, int min_i, int min_j, int max_i, int max_j) = 0;
  virtual void matchSize() {}
  [[nodiscard]] bool isCurrent() const { return current_; }
  [[nodiscard]] bool isEnabled() const { return enabled_; }
  [[nodiscard]] const std::vector<geometry_msgs::msg::Point>& getFootprint() const;

 protected:
  virtual void onInitialize() {}

  LayeredCostmap* layered_costmap_{nullptr};
  std::string name_;
  tf2_ros::Buffer* tf_{nullptr};
  nav2::LifecycleNode::WeakPtr node_;
  rclcpp::Clock::SharedPtr clock_;
  rclcpp::Logger logger_{rclcpp::get_logger("nav2_costmap_2d")};
  std::atomic_bool current_{false};
  bool enabled_{false};
};

class LayeredCostmap {
 public:
  LayeredCostmap(std::string global_frame, bool is_rolling, bool tracks_unknown)
      : global_frame_{std::move(global_frame)}, is_rolling_{is_rolling} {
    primary_.setDefaultValue(tracks_unknown ? NO_INFORMATION : FREE_SPACE);
    combined_.setDefaultValue(primary_.getDefaultValue());
  }

  void addPlugin(std::shared_ptr<Layer> plugin) { plugins_.push_back(std::move(plugin)); }
  void addFilter(std::shared_ptr<Layer> filter) { filters_.push_back(std::move(filter)); }
  void resizeMap(unsigned int size_x, unsigned int size_y, double resolution, double origin_x, double origin_y) {
    primary_.resizeMap(size_x, size_y, resolution, origin_x, origin_y);
    combined_.resizeMap(size_x, size_y, resolution, origin_x, origin_y);
    for (const auto& plugin : plugins_) plugin->matchSize();
  }
  void updateMap(double x, double y, double yaw) {
    if (is_rolling_) {
      for (Costmap2D* const one : {&primary_, &combined_}) {
        one->updateOrigin(x - one->getSizeInMetersX() / 2, y - one->getSizeInMetersY() / 2);
      }
    }
    double min_x{std::numeric_limits<double>::max()};
    double min_y{min_x};
    double max_x{std::numeric_limits<double>::lowest()};
    double max_y{max_x};
    for (const auto* layers : {&plugins_, &filters_}) {
      for (const auto& layer : *layers) layer->updateBounds(x, y, yaw, &min_x, &min_y, &max_x, &max_y);
    }
    int x0{0};
    int y0{0};
    int xn{0};
    int yn{0};
    combined_.worldToMapEnforceBounds(min_x, min_y, x0, y0);
    combined_.worldToMapEnforceBounds(max_x, max_y, xn, yn);
    xn = std::min(static_cast<int>(combined_.getSizeInCellsX()), xn + 1);
    yn = std::min(static_cast<int>(combined_.getSizeInCellsY()), yn + 1);
    if (xn < x0 || yn < y0) return;
    Costmap2D& master{filters_.empty() ? combined_ : primary_};
    master.resetMapToValue(x0, y0, xn, yn, master.getDefaultValue());
    for (const auto& plugin : plugins_) plugin->updateCosts(master, x0, y0, xn, yn);
    if (filters_.empty()) return;
    for (int y_cell{y0}; y_cell < yn; ++y_cell) {
      for (int x_cell{x0}; x_cell < xn; ++x_cell) combined_.setCost(x_cell, y_cell, primary_.getCost(x_cell, y_cell));
    }
    for (const auto& filter : filters_) filter->updateCosts(combined_, x0, y0, xn, yn);
  }
  [[nodiscard]] bool isCurrent() const {
    return std::ranges::all_of(plugins_, [](const auto& one) { return one->isCurrent() || !one->isEnabled(); });
  }
  [[nodiscard]] bool isRolling() const { return is_rolling_; }
  [[nodiscard]] std::string getGlobalFrameID() const { return global_frame_; }
  [[nodiscard]] Costmap2D* getCostmap() { return &combined_; }
  void setFootprint(std::vector<geometry_msgs::msg::Point> footprint) { footprint_ = std::move(footprint); }
  [[nodiscard]] const std::vector<geometry_msgs::msg::Point>& getFootprint() const { return footprint_; }

 private:
  std::string global_frame_;
  bool is_rolling_;
  Costmap2D primary_;
  Costmap2D combined_;
  std::vector<std::shared_ptr<Layer>> plugins_;
  std::vector<std::shared_ptr<Layer>> filters_;
  std::vector<geometry_msgs::msg::Point> footprint_;
};

inline const std::vector<geometry_msgs::msg::Point>& Layer::getFootprint() const {
  return layered_costmap_->getFootprint();
}

class CostmapLayer : public Layer, public Costmap2D {
 public:
  void matchSize() override {
    const Costmap2D& master{*layered_costmap_->getCostmap()};
    resizeMap(master.getSizeInCellsX(), master.getSizeInCellsY(), master.getResolution(), master.getOriginX(),
              master.getOriginY());
  }

 protected:
  void touch(double x, double y, double* min_x, double* min_y, double* max_x, double* max_y) {
    *min_x = std::min(x, *min_x);
    *min_y = std::min(y, *min_y);
    *max_x = std::max(x, *max_x);
    *max_y = std::max(y, *max_y);
  }
  void useExtraBounds(double*, double*, double*, double*) {}  // without addExtraBounds()
  void updateWithMax(Costmap2D& master, int min_i, int min_j, int max_i, int max_j) {
    update(master, min_i, min_j, max_i, max_j, [](int old, int own) { return old == NO_INFORMATION || old < own; });
  }
  void updateWithOverwrite(Costmap2D& master, int min_i, int min_j, int max_i, int max_j) {
    update(master, min_i, min_j, max_i, max_j, [](int, int) { return true; });
  }

 private:
  template <class Replaces>
  void update(Costmap2D& master, int min_i, int min_j, int max_i, int max_j, Replaces replaces) {
    if (!enabled_) return;
    for (int j{min_j}; j < max_j; ++j) {
      for (int i{min_i}; i < max_i; ++i) {
        const unsigned char own{getCost(i, j)};
        if (own != NO_INFORMATION && replaces(master.getCost(i, j), own)) master.setCost(i, j, own);
      }
    }
  }
};

}  // namespace nav2_costmap_2d
