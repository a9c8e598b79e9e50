//! `beeline serve` on a robot: a serial port that several commands use at once, and what the page may ask.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Child;

use serde_json::{Value, json};

use super::PTY;
use crate::outcome::wait_for;
use crate::served::{Served, interrupt};
use crate::temp_folder::TempFolder;

/// The page of a robot, served.
struct RobotPage {
    child: Child,
    address: String,
}

impl Drop for RobotPage {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl RobotPage {
    /// Announces the port in a folder of the test's own.
    fn of(temp: &TempFolder, port: &str) -> Self {
        let arguments = ["serve", "--no-open", "--json", "--listen", "127.0.0.1:0", "--port", port];
        let mut command = temp.command(&arguments);
        let mut child = command.env("XDG_RUNTIME_DIR", temp.path("")).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let link =
            serde_json::from_str::<Value>(&line).unwrap()["link"].as_str().unwrap().to_owned();
        let address = link.strip_prefix("http://").unwrap().trim_end_matches('/').to_owned();
        Self { child, address }
    }

    fn post(&self, path: &str, question: &Value) -> u16 {
        let body = question.to_string();
        let mut stream = TcpStream::connect(&self.address).unwrap();
        let head = format!(
            "POST {path} HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nConnection: close\r\n\
             Content-Length: {}\r\n\r\n",
            self.address,
            body.len()
        );
        stream.write_all(&[head.as_bytes(), body.as_bytes()].concat()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer.split(' ').nth(1).unwrap().parse().unwrap()
    }

    /// The next news.
    fn news(&self) -> Value {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        let head = format!("GET /api/telemetry HTTP/1.1\r\nHost: {}\r\n\r\n", self.address);
        stream.write_all(head.as_bytes()).unwrap();
        let lines = BufReader::new(stream).lines();
        let data = lines
            .map_while(Result::ok)
            .find_map(|line| Some(line.strip_prefix("data: ")?.to_owned()));
        serde_json::from_str(&data.unwrap()).unwrap()
    }

    fn state(&self) -> String {
        self.news()["condition"]["state"].as_str().unwrap_or_default().to_owned()
    }

    /// As a page does it that has just heard the robot.
    fn hold(&self, number: u64, motion: &Value) -> u16 {
        let heard = self.news()["now_ms"].clone();
        self.post(
            "/api/hold",
            &json!({"page": 1, "number": number, "motion": motion, "heard_ms": heard}),
        )
    }
}

#[test]
fn a_serial_port_that_a_page_owns_is_found_by_other_commands_and_each_may_watch_and_stop() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, PTY);
    let page = RobotPage::of(&temp, robot.port());
    wait_for("the robot on the page", || (page.state() == "idle").then_some(()));
    let run = |arguments: &str| {
        let words: Vec<&str> = arguments.split(' ').chain(["--port", robot.port()]).collect();
        let mut command = temp.command(&words);
        let child = command.env("XDG_RUNTIME_DIR", temp.path("")).spawn().unwrap();
        crate::outcome::collect(child)
    };
    // By the port's name alone, while the page has the port.
    assert_eq!(run("identify --json").ok().json()["status"]["state"], "idle");
    // A second page does not take the port from the first.
    let second = RobotPage::of(&temp, robot.port());
    wait_for("the robot on the second page", || (second.state() == "idle").then_some(()));
    let far = json!({"straight": {"distance_m": 5.0, "speed_mps": 0.2}});
    let drive = |number: u64| {
        wait_for("the drive", || {
            assert_eq!(page.hold(number, &far), 200);
            (page.state() == "driving").then_some(())
        });
    };
    drive(1);
    // Whoever comes in between neither stops it nor drives itself.
    let held = |number: u64, arguments: &str| {
        std::thread::scope(|scope| {
            let command = scope.spawn(|| run(arguments));
            while !command.is_finished() {
                page.hold(number, &far);
            }
            command.join().unwrap()
        })
    };
    let identified = held(1, "identify --json").ok().json();
    assert_eq!(identified["status"]["state"], "driving");
    assert_eq!(second.state(), "driving");
    // Nor does another page: its motion would be a turn.
    let spin = json!({"spin": {"angle_rad": 6.0, "speed_mps": 0.1}});
    let heard = page.news()["now_ms"].clone();
    page.post("/api/hold", &json!({"page": 2, "number": 9, "motion": spin, "heard_ms": heard}));
    page.hold(1, &far);
    assert_eq!(page.news()["condition"]["page"], 1);
    page.hold(1, &far);
    let refused = held(1, "drive straight 10cm").refused();
    assert!(refused.contains("already driving"), "{refused}");
    // A drive whose host is silent is a fault, as with any other host.
    wait_for("the end of what nobody holds", || (page.state() == "faulted").then_some(()));
    page.post("/api/clear", &json!({}));
    wait_for("the end of the fault", || (page.state() == "idle").then_some(()));
    drive(2);
    // Whoever still holds does not drive it again.
    held(2, "stop").ok();
    wait_for("the stop of another command", || {
        let state = page.state();
        (state == "idle" || state == "armed").then_some(())
    });
}

#[test]
fn what_a_page_asks_that_has_not_heard_the_robot_lately_moves_nothing() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, "tcp:127.0.0.1:0");
    let page = RobotPage::of(&temp, robot.port());
    wait_for("the robot on the page", || (page.state() == "idle").then_some(()));
    let motion = json!({"velocity": {"forward_mps": 0.1, "turn_rad_s": 0.0}});
    let stale = json!({"page": 1, "number": 1, "motion": motion, "heard_ms": 0});
    std::thread::sleep(std::time::Duration::from_millis(300));
    for _ in 0..10 {
        assert_eq!(page.post("/api/hold", &stale), 200);
    }
    assert_eq!(page.state(), "idle");
    let counts = page.news()["rows"].as_array().unwrap().last().unwrap()[7].clone();
    assert_eq!(counts, 0, "the setpoint has not moved");
    // What is no number, or no motion, is refused with a reason.
    for question in [
        json!({}),
        json!({"page": 1, "number": 1, "motion": {"fly": {}}, "heard_ms": 0}),
        json!([1]),
    ] {
        assert_eq!(page.post("/api/hold", &question), 400, "{question}");
    }
    // More than the robot may do is the robot's to refuse, and the page says so.
    let fast = json!({"velocity": {"forward_mps": 50.0, "turn_rad_s": 0.0}});
    page.hold(2, &fast);
    let message =
        wait_for("the refusal", || page.news()["condition"]["message"].as_str().map(str::to_owned));
    assert!(message.contains("refused"), "{message}");
    assert_eq!(page.post("/api/cut", &json!({})), 200);
    let fault = wait_for("the fault", || {
        page.news()["condition"]["fault"]["words"].as_str().map(str::to_owned)
    });
    assert!(fault.starts_with("emergency_stop"), "{fault}");
    assert_eq!(page.post("/api/clear", &json!({})), 200);
    wait_for("the end of the fault", || (page.state() == "idle").then_some(()));
}

#[test]
fn ctrl_c_leaves_a_robot_that_the_page_drives_standing_and_ends_in_order() {
    for listen in ["tcp:127.0.0.1:0", PTY] {
        let temp = TempFolder::new();
        let robot = Served::start(&temp, listen);
        let mut page = RobotPage::of(&temp, robot.port());
        wait_for("the robot on the page", || (page.state() == "idle").then_some(()));
        let far = json!({"straight": {"distance_m": 5.0, "speed_mps": 0.3}});
        wait_for("the drive", || {
            page.hold(1, &far);
            (page.state() == "driving").then_some(())
        });
        for _ in 0..10 {
            page.hold(1, &far);
        }
        interrupt(&page.child);
        let status = wait_for("the end", || page.child.try_wait().unwrap());
        assert_eq!(status.code(), Some(0), "as `beeline sim`, which Ctrl-C ends as well");
        // Motors off and no fault: it was stopped, and did not lose its host.
        let there = robot.identify();
        assert_eq!(there["status"]["state"], "idle", "{there}");
        assert_eq!(there["status"]["fault"], Value::Null, "{there}");
        assert!(robot.travelled_m() < 3.0);
        // Nobody is told of a port that has no owner any more.
        let announced = std::fs::read_dir(temp.path("beeline"));
        let announced = announced.into_iter().flatten().flatten().map(|file| file.path());
        let ports: Vec<_> = announced.filter(|file| file.extension().is_none()).collect();
        assert_eq!(ports, [] as [std::path::PathBuf; 0]);
    }
}
