//! `beeline serve` and `report --interactive`: the same figures as the other commands, for the page alone.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Child;
use std::time::Duration;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::example::runs_of;
use crate::outcome::wait_for;
use crate::temp_folder::TempFolder;

/// A page that is served.
struct Page {
    child: Child,
    address: String,
    /// What stands behind the address in the link.
    query: String,
}

impl Drop for Page {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// An answer: its status, its headers in lower case, its body.
struct Answer {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Answer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }
}

impl Page {
    fn of(temp: &TempFolder, listen: &str) -> Self {
        runs_of(temp, "mystery-robot", &[""], "robot");
        let mut child = temp.spawn(&["serve", "robot", "--no-open", "--json", "--listen", listen]);
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let link =
            serde_json::from_str::<Value>(&line).unwrap()["link"].as_str().unwrap().to_owned();
        let (address, query) = link.strip_prefix("http://").unwrap().split_once('/').unwrap();
        Self { child, address: address.to_owned(), query: query.to_owned() }
    }

    /// Sends bytes as they are, and reads until the server ends the connection. It does so without an answer if no more
    /// `follows` an incomplete request.
    fn raw(&self, bytes: &[u8], follows: bool) -> Vec<u8> {
        let port = self.address.rsplit_once(':').unwrap().1;
        let mut stream = TcpStream::connect(format!("127.0.0.1:{port}")).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        // Whoever refuses a request may close before it has read all of it.
        let _ = stream.write_all(bytes);
        if !follows {
            let _ = stream.shutdown(std::net::Shutdown::Write);
        }
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        answer
    }

    fn ask(&self, line: &str, headers: &str, body: &str) -> Answer {
        let request = format!(
            "{line} HTTP/1.1\r\n{headers}Connection: close\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        let answer = self.raw(request.as_bytes(), true);
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("an answer");
        let head = String::from_utf8(answer[..end].to_vec()).unwrap().to_lowercase();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Answer { status, head, body: answer[end + 4..].to_vec() }
    }

    fn get(&self, path: &str) -> Answer {
        self.ask(&format!("GET {path}"), &format!("Host: {}\r\n", self.address), "")
    }

    fn post(&self, path: &str, question: &Value) -> Answer {
        let headers = format!("Host: {}\r\nContent-Type: application/json\r\n", self.address);
        self.ask(&format!("POST {path}"), &headers, &question.to_string())
    }

    fn model(&self, ids: &[&str]) -> Value {
        let effects: Vec<_> = ids.iter().map(|id| json!({"id": id})).collect();
        let answer = self.post("/api/model", &json!({"effects": effects}));
        assert_eq!(answer.status, 200, "{}", answer.json());
        answer.json()
    }
}

#[test]
fn the_figures_are_those_of_model_add_and_of_explain() {
    let temp = TempFolder::new();
    let page = Page::of(&temp, "127.0.0.1:0");
    let nominal = page.model(&[]);
    let shown = page.model(&["speed_growth"]);
    let added = temp.run("model add speed_growth robot --json").ok().json();
    assert_eq!(shown["errors"]["fitted"], added["after"]["train"]);
    assert_eq!(shown["errors"]["cross_validated"], added["after"]["heldout"]);
    assert_eq!(nominal["errors"]["cross_validated"], added["before"]["heldout"]);
    assert_eq!(shown["effects"][0]["parameters"], added["effects"][0]["parameters"]);
    assert_eq!(shown["effects"][0]["verdict"], added["effects"][0]["verdict"]);
    let mm = |model: &Value| {
        model["errors"]["cross_validated"]["position_rms_m"].as_f64().unwrap() * 1e3
    };
    assert!(mm(&nominal) > 5.5 && mm(&shown) < 1.6, "{} {}", mm(&nominal), mm(&shown));

    // What was saved by `model add` is what the page saves.
    let by_command = temp.read("robot/model.toml");
    std::fs::remove_file(temp.path("robot/model.toml")).unwrap();
    let saved = page.post("/api/save", &json!({"effects": [{"id": "speed_growth"}]}));
    assert_eq!(saved.status, 200, "{}", saved.json());
    assert_eq!(temp.read("robot/model.toml"), by_command);

    let explained = wait_for("explain to end", || {
        let explanation = page.get("/api/explanation").json();
        explanation["answer"].is_object().then_some(explanation)
    });
    assert!(explained["found"].as_array().unwrap().len() >= 2, "{}", explained["found"]);
    std::fs::remove_file(temp.path("robot/model.toml")).unwrap();
    let told = temp.run("explain robot --json").ok().json();
    for key in ["verdict", "steps", "rejected", "floor", "baseline"] {
        assert_eq!(explained["answer"][key], told[key], "{key}");
    }
}

#[test]
fn a_quick_answer_has_the_values_at_once_and_the_rest_when_it_is_known() {
    let temp = TempFolder::new();
    let page = Page::of(&temp, "127.0.0.1:0");
    let quick = |ids: &[&str]| {
        let effects: Vec<Value> = ids.iter().map(|id| json!({"id": id})).collect();
        page.post("/api/model", &json!({"effects": effects, "quick": true})).json()
    };
    // Several at once: nobody has fitted them in advance.
    let ids = ["scrub", "side_slip", "speed_growth"];
    let (first, fitted) = (quick(&ids), page.model(&ids));
    assert_eq!(first["quick"], true, "{first}");
    assert_eq!(first["errors"]["cross_validated"], Value::Null);
    let value = |model: &Value| model["effects"][2]["parameters"][0]["value"].as_f64().unwrap();
    assert!((value(&first) / value(&fitted) - 1.0).abs() < 0.02, "{first} {fitted}");
    // Known by now, and told whole.
    assert_eq!(quick(&ids), fitted);
}

#[test]
fn values_set_by_hand_are_compared_as_they_are() {
    let temp = TempFolder::new();
    let page = Page::of(&temp, "127.0.0.1:0");
    let by_hand = |value: f64| {
        let question = json!({"effects": [{"id": "speed_growth", "values": [value]}]});
        page.post("/api/model", &question).json()
    };
    let fitted = page.model(&["speed_growth"]);
    let best = fitted["effects"][0]["parameters"][0]["value"].as_f64().unwrap();
    let error = |model: &Value| model["errors"]["fitted"]["position_rms_m"].as_f64().unwrap();
    let same = by_hand(best);
    assert!(
        (error(&same) / error(&fitted) - 1.0).abs() < 1e-4,
        "{} {}",
        error(&same),
        error(&fitted)
    );
    assert_eq!(same["errors"]["cross_validated"], Value::Null);
    assert!(error(&by_hand(0.0)) > 3.0 * error(&same));
    assert!(error(&by_hand(2.0 * best)) > 3.0 * error(&same));
    assert_eq!(
        same["curves"].as_array().unwrap().len(),
        fitted["curves"].as_array().unwrap().len()
    );
    let refused =
        page.post("/api/save", &json!({"effects": [{"id": "speed_growth", "values": [best]}]}));
    assert_eq!(refused.status, 422);
    assert!(!temp.path("robot/model.toml").exists());
}

#[test]
fn an_equation_is_checked_as_it_is_typed_and_then_fitted_like_any_effect() {
    let temp = TempFolder::new();
    let page = Page::of(&temp, "127.0.0.1:0");
    let check = |equation: &str| page.post("/api/equation", &json!({"equation": equation}));
    for (equation, problem) in [
        ("dtheta", "there is no ="),
        ("dtheta = k * omga", "omga"),
        ("dtheta = k * (v + omega)", "different units"),
    ] {
        let answer = check(equation);
        assert_eq!(answer.status, 422, "{equation}");
        let told = answer.json();
        assert!(told["error"].as_str().unwrap().contains(problem), "{equation}: {told}");
        assert!(!told["hint"].as_str().unwrap().is_empty(), "{equation}: {told}");
    }
    let equation = "ds_left = k * v_left^3";
    assert_eq!(check(equation).json()["parameters"][0]["unit"], "s^2/m^2");
    let added = page.post("/api/equation", &json!({"equation": equation, "add": true})).json();
    let id = added["id"].as_str().unwrap();
    let again = page.post("/api/equation", &json!({"equation": equation, "add": true})).json();
    assert_eq!(again["id"], id, "the same equation twice is one effect");
    let shown = page.model(&[id]);
    let added =
        temp.run_with(&["model", "add", "--custom", equation, "robot", "--json"], "").ok().json();
    assert_eq!(shown["errors"]["cross_validated"], added["after"]["heldout"]);
}

#[test]
fn other_pages_and_other_names_of_this_machine_are_refused() {
    let temp = TempFolder::new();
    let page = Page::of(&temp, "127.0.0.1:0");
    let address = &page.address;
    let own = format!("Host: {address}\r\n");
    let asked = |headers: &str| page.ask("GET /api/campaign", headers, "").status;
    assert_eq!(asked(&own), 200);
    assert_eq!(asked(&format!("{own}Origin: http://{address}\r\n")), 200);
    // A page of somebody else's; a name that leads here after all (DNS rebinding).
    assert_eq!(asked(&format!("{own}Origin: http://evil.example\r\n")), 403);
    assert_eq!(asked(&format!("{own}Origin: null\r\n")), 403);
    assert_eq!(asked("Host: evil.example\r\n"), 403);
    let port = address.rsplit_once(':').unwrap().1;
    assert_eq!(asked(&format!("Host: evil.example:{port}\r\n")), 403);
    // A form can post text, but no JSON; and no preflight is answered in its favour.
    let question = json!({"effects": [{"id": "speed_growth"}]}).to_string();
    let form = page.ask("POST /api/save", &format!("{own}Content-Type: text/plain\r\n"), &question);
    assert_eq!(form.status, 415);
    let preflight =
        page.ask("OPTIONS /api/save", &format!("{own}Origin: http://evil.example\r\n"), "");
    assert!(!preflight.head.contains("access-control-allow"), "{}", preflight.head);
    assert!(!temp.path("robot/model.toml").exists());
    let head = page.get("/").head;
    for header in
        ["content-security-policy: default-src 'none'", "nosniff", "frame-ancestors 'none'"]
    {
        assert!(head.contains(header), "{header}: {head}");
    }
}

#[test]
fn beyond_this_machine_the_link_has_a_key() {
    let temp = TempFolder::new();
    let page = Page::of(&temp, "0.0.0.0:0");
    let key = page.query.strip_prefix("?key=").unwrap();
    assert_eq!(page.get("/api/campaign").status, 403);
    assert_eq!(page.get("/").status, 403);
    assert_eq!(page.get(&format!("/?key={key}")).status, 200);
    assert_eq!(page.get("/page.css").status, 200);
    let headers = format!("Host: {}\r\nX-Beeline-Key: {key}\r\n", page.address);
    assert_eq!(page.ask("GET /api/campaign", &headers, "").status, 200);
    let wrong = headers.replace(key, &"0".repeat(key.len()));
    assert_eq!(page.ask("GET /api/campaign", &wrong, "").status, 403);
}

#[test]
fn whatever_is_asked_the_page_goes_on() {
    let temp = TempFolder::new();
    let page = Page::of(&temp, "127.0.0.1:0");
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let sound = json!({"effects": [{"id": "speed_growth", "values": [0.05]}]}).to_string();
    for _ in 0..150 {
        // A question of which some bytes are others, under a right head.
        let mut body = sound.clone().into_bytes();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..body.len());
            body[at] = random.random();
        }
        let path = ["model", "equation", "save"][random.random_range(0..3)];
        let head = format!(
            "POST /api/{path} HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nConnection: close\r\n\
             Content-Length: {}\r\n\r\n",
            page.address,
            body.len()
        );
        let answer = page.raw(&[head.as_bytes(), &body].concat(), true);
        assert!(answer.starts_with(b"HTTP/1.1 "), "{}", String::from_utf8_lossy(&body));
        assert!(!answer.starts_with(b"HTTP/1.1 5"), "{}", String::from_utf8_lossy(&body));
        let mut noise = vec![0; random.random_range(0..200)];
        random.fill_bytes(&mut noise);
        page.raw(&noise, false);
    }
    let large = "x".repeat(100_000);
    let answer = page.post("/api/equation", &json!({"equation": large}));
    assert_eq!(answer.status, 413);
    assert_eq!(answer.json(), json!({"error": "a question has at most 64 KiB"}));
    for (question, problem) in [
        (json!({"effects": [{"id": "no_such"}]}), "no effect `no_such`"),
        (json!({"effects": [{"id": "scrub"}, {"id": "scrub"}]}), "twice"),
    ] {
        let answer = page.post("/api/model", &question);
        assert_eq!(answer.status, 422);
        assert!(answer.json()["error"].as_str().unwrap().contains(problem));
    }
    assert_eq!(page.get("/nothing").status, 404);
    assert_eq!(page.get("/api/model").status, 405);
    assert_eq!(page.model(&[])["effects"], json!([]));
}

#[test]
fn a_place_that_is_taken_is_one_clear_error() {
    let temp = TempFolder::new();
    let page = Page::of(&temp, "127.0.0.1:0");
    let told = temp.run(&format!("serve robot --no-open --listen {}", page.address)).refused();
    assert!(told.contains("cannot serve the page") && told.contains("--listen"), "{told}");
}

#[test]
fn the_page_as_one_file_has_the_answers_in_it() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    // A name that would end the script in which it stands.
    let file = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
    let renamed = file.replacen("name = \"mystery robot\"", "name = \"</script><b>\"", 1);
    assert_ne!(file, renamed);
    temp.write("robot/robot.toml", &renamed);
    temp.run("report robot --interactive -o page.html").ok();
    let page = String::from_utf8(temp.read("page.html")).unwrap();
    assert!(!page.contains("src=\"") && !page.contains("href=\"page"), "it needs other files");
    let (_, rest) = page.split_once("id=\"recorded\">").unwrap();
    let recorded: Value = serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap();
    assert_eq!(recorded["campaign"]["robot"], "</script><b>");
    let models = recorded["models"].as_object().unwrap();
    let catalogue = recorded["campaign"]["catalogue"].as_array().unwrap();
    assert!(models.len() > catalogue.len(), "{}", models.len());
    let added = temp.run("model add speed_growth robot --json").ok().json();
    assert_eq!(models["speed_growth"]["errors"]["cross_validated"], added["after"]["heldout"]);
    assert_eq!(models[""]["errors"]["fitted"], added["before"]["train"]);
    let told = temp.run("report robot --interactive -o page.svg").refused();
    assert!(told.contains(".html"), "{told}");
}
