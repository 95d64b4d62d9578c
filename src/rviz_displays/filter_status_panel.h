#pragma once

#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTimer>

#include <hymm/FilterHealth.h>
#include <hymm/FilterStatus.h>
#include <rviz/panel.h>

#include "rviz_displays/service_calls.h"

namespace hymm {

/// Which filter is in charge and why, how well it explains what the sensors say, and buttons for
/// what a person may want of it.
class FilterStatusPanel : public rviz::Panel {
  Q_OBJECT

 public:
  explicit FilterStatusPanel(QWidget* parent = nullptr);

  void onInitialize() override;
  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private Q_SLOTS:
  void relocalise();
  void pause();
  void saveMap();
  void refresh();

 private:
  void takeStatus(const FilterStatus& message);
  void takeHealth(const FilterHealth& message);
  void showMode(const QString& mode, const QString& reason);
  void answer(const QString& sentence);

  QLabel *mode_, *reason_, *evidence_, *health_, *answer_;
  QLineEdit* path_;
  QPushButton *relocalise_, *pause_, *save_;
  QTimer timer_;
  bool paused_ = false;
  ros::WallTime health_at_;

  ros::NodeHandle handle_;
  ros::Subscriber status_subscriber_, health_subscriber_;
  ServiceCalls calls_;
};

}  // namespace hymm
