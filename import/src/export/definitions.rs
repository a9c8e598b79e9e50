//! The definitions of messages, as a bag has them for programs that do not know ROS 2: the type, then those it is made of.

/// The definition of a type that others are made of.
macro_rules! part {
    (header) => {
        "\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
"
    };
    (time) => {
        "\
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"
    };
    (interface_value) => {
        "\
================================================================================
MSG: control_msgs/InterfaceValue
string[] interface_names
float64[] values
"
    };
    (quaternion) => {
        "\
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"
    };
    (vector3) => {
        "\
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"
    };
    (pose) => {
        "\
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
"
    };
    (pose_stamped) => {
        "\
================================================================================
MSG: geometry_msgs/PoseStamped
std_msgs/Header header
geometry_msgs/Pose pose
"
    };
    (point) => {
        "\
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
"
    };
    (pose_with_covariance) => {
        "\
================================================================================
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
"
    };
    (twist_with_covariance) => {
        "\
================================================================================
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
"
    };
    (twist) => {
        "\
================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
"
    };
}

/// `sensor_msgs/msg/JointState`.
pub(super) const JOINT_STATE: &str = concat!(
    "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
",
    part!(header),
    part!(time),
);

/// `control_msgs/msg/DynamicJointState`.
pub(super) const DYNAMIC_JOINT_STATE: &str = concat!(
    "\
std_msgs/Header header
string[] joint_names
control_msgs/InterfaceValue[] interface_values
",
    part!(interface_value),
    part!(header),
    part!(time),
);

/// `sensor_msgs/msg/BatteryState`, without its constants.
pub(super) const BATTERY_STATE: &str = concat!(
    "\
std_msgs/Header header
float32 voltage
float32 temperature
float32 current
float32 charge
float32 capacity
float32 design_capacity
float32 percentage
uint8 power_supply_status
uint8 power_supply_health
uint8 power_supply_technology
bool present
float32[] cell_voltage
float32[] cell_temperature
string location
string serial_number
",
    part!(header),
    part!(time),
);

/// `sensor_msgs/msg/Imu`.
pub(super) const IMU: &str = concat!(
    "\
std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
",
    part!(quaternion),
    part!(vector3),
    part!(header),
    part!(time),
);

/// `geometry_msgs/msg/PoseStamped`.
pub(super) const POSE_STAMPED: &str = concat!(
    "\
std_msgs/Header header
geometry_msgs/Pose pose
",
    part!(header),
    part!(time),
    part!(pose),
    part!(point),
    part!(quaternion),
);

/// `nav_msgs/msg/Path`.
pub(super) const PATH: &str = concat!(
    "\
std_msgs/Header header
geometry_msgs/PoseStamped[] poses
",
    part!(header),
    part!(time),
    part!(pose_stamped),
    part!(pose),
    part!(point),
    part!(quaternion),
);

/// `geometry_msgs/msg/Vector3Stamped`.
pub(super) const VECTOR3_STAMPED: &str = concat!(
    "\
std_msgs/Header header
geometry_msgs/Vector3 vector
",
    part!(header),
    part!(time),
    part!(vector3),
);

/// `nav_msgs/msg/Odometry`.
pub(super) const ODOMETRY: &str = concat!(
    "\
std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
",
    part!(header),
    part!(time),
    part!(pose_with_covariance),
    part!(pose),
    part!(point),
    part!(quaternion),
    part!(twist_with_covariance),
    part!(twist),
    part!(vector3),
);
