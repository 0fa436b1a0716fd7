//! The message `sensor_msgs/msg/JointState` of ROS 2 in CDR, the encoding of its middleware (little-endian, OMG CDR
//! 1.0).

/// The definition of the message and of the messages that it refers to, as MCAP requires for the encoding `ros2msg`.
pub(super) const JOINT_STATE: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// The bytes before the message, which name its encoding. Alignment counts from the byte after them.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message that is being encoded.
struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    fn align(&mut self, to: usize) {
        let length = self.bytes.len() - ENCAPSULATION.len();
        self.bytes.resize(ENCAPSULATION.len() + length.next_multiple_of(to), 0);
    }

    fn u32(&mut self, number: u32) {
        self.align(4);
        self.bytes.extend(number.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        // Names of joints are short.
        self.u32(text.len() as u32 + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    fn numbers(&mut self, numbers: &[f64]) {
        self.u32(numbers.len() as u32);
        for number in numbers {
            self.align(8);
            self.bytes.extend(number.to_le_bytes());
        }
    }
}

/// Encodes the state of joints at a time; `velocity` and `effort` may be empty.
pub(super) fn joint_state(
    nanoseconds: u64,
    names: &[String],
    position: &[f64],
    velocity: &[f64],
    effort: &[f64],
) -> Vec<u8> {
    let mut message = Cdr { bytes: ENCAPSULATION.to_vec() };
    // A reach is far shorter than 68 years.
    message.u32((nanoseconds / 1_000_000_000) as u32);
    message.u32((nanoseconds % 1_000_000_000) as u32);
    message.text("");
    message.u32(names.len() as u32);
    names.iter().for_each(|name| message.text(name));
    for numbers in [position, velocity, effort] {
        message.numbers(numbers);
    }
    message.bytes
}
