//! The view, by plain HTTP requests.

use std::net::TcpListener;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::program::{Workplace, signal};
use crate::view_server::{Answer, ViewServer};

/// Two balls side by side, in front of nothing.
const SPHERES: &str = r#"(
    camera: (look_from: (0, 0, 6), look_at: (0, 0, 0), fov: 40),
    film: (size: (96, 64)),
    background: gradient(bottom: gray(0.1), top: rgb(0.2, 0.4, 0.9)),
    lights: [point(position: (-4, 6, 5), intensity: gray(0.8))],
    materials: {
        "red": phong(color: rgb(0.9, 0.1, 0.1), specular: gray(0.3)),
        "mirror": phong(diffuse: gray(0.1), mirror: gray(0.8)),
    },
    nodes: [
        (name: "left ball", shape: sphere(center: (-1.5, 0, 0), radius: 1), material: "red"),
        (name: "right ball", shape: sphere(center: (1.5, 0, 0), radius: 1), material: "mirror"),
    ],
)"#;

/// The camera of [`SPHERES`].
const CAMERA: &str = "camera: (look_from: (0, 0, 6), look_at: (0, 0, 0), fov: 40),";

/// The camera as text, and the scene with it in the file `pasted.ron`.
fn paste_camera(view: &ViewServer) -> String {
    let text = view.get("camera").text();
    assert!(SPHERES.contains(CAMERA));
    view.place.write("pasted.ron", SPHERES.replace(CAMERA, &text));
    text
}

fn vector(value: &Value) -> [f64; 3] {
    core::array::from_fn(|axis| value[axis].as_f64().expect("a number"))
}

#[test]
fn the_page_shows_what_render_writes() {
    for options in [
        "--spp 6",
        "--spp 4 --integrator path --exposure 1 --look-from 2,1,5 --threads 2",
        "--spp 3 --background transparent --tone aces",
        "--spp 2 --integrator caustics",
        "--integrator normals --spp 2",
    ] {
        ViewServer::start(SPHERES, options).assert_shows("scene.ron", options);
    }
}

#[test]
fn settings_show_what_render_writes_with_the_same_options() {
    let scene = SPHERES.replace("film: (size: (96, 64))", "film: (size: (96, 64), exposure: 0.5, tone: reinhard)");
    let view = ViewServer::start(&scene, "--spp 4");
    view.assert_shows("scene.ron", "--spp 4");
    for (settings, options) in [
        (json!({ "exposure": -1.5, "tone": "aces" }), "--spp 4 --exposure -1.5 --tone aces"),
        (json!({ "integrator": "path", "spp": 5 }), "--spp 5 --exposure -1.5 --tone aces --integrator path"),
        (json!({ "integrator": "depth" }), "--spp 5 --integrator depth"),
        (json!({ "size": [50, 61] }), "--spp 5 --integrator depth --size 50x61"),
        (json!({ "integrator": "whitted" }), "--spp 5 --exposure -1.5 --tone aces --size 50x61"),
    ] {
        view.post("settings", &settings.to_string());
        view.assert_shows("scene.ron", options);
    }
    let (state, _) = view.finished();
    assert_eq!(state["wanted_size"], json!([50, 61]));
    for refused in [
        json!({ "integrator": "none" }),
        json!({ "tone": "none" }),
        json!({ "exposure": 1e4 }),
        json!({ "spp": 0 }),
        json!({ "spp": (1_u32 << 31) + 1 }),
        json!({ "spp": u32::MAX }),
        json!({ "size": [0, 5] }),
        json!({ "size": [30_000, 30_000] }),
        json!({ "colour": 1 }),
        json!({ "spp": "many" }),
        json!([]),
    ] {
        assert_eq!(view.request("POST", "settings", &refused.to_string()).status, 400, "{refused}");
    }
    for field in ["max_spp", "wanted_size"] {
        assert_eq!(view.finished().0[field], state[field], "what is refused changes nothing");
    }
}

#[test]
fn an_image_beyond_the_memory_limit_is_refused_with_a_message() {
    let view = ViewServer::start(SPHERES, "--spp 1 --memory 64MiB");
    view.finished();
    view.post("settings", &json!({ "size": [3000, 2000] }).to_string());
    let (state, _) = view.watch(|state| state["message"].is_string());
    assert!(
        state["message"]
            .as_str()
            .is_some_and(|message| message.contains("above the limit of 64.0 MiB (raise --memory)")),
        "{state}"
    );
    view.post("settings", &json!({ "size": [96, 64] }).to_string());
    view.assert_shows("scene.ron", "--spp 1");
}

/// The prediction lacked the copies of the image that the page receives.
#[test]
fn copies_of_a_viewed_image_count_as_memory() {
    let place = Workplace::with("scene.ron", SPHERES);
    // The port is taken, so that the program ends in any case.
    let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
    let port = listener.local_addr().expect("an address").port();
    let view = |limit: &str| place.run(&format!("view scene.ron --size 2000x2000 --port {port} --memory {limit}"));
    let run = view("800MiB");
    assert!(run.code == Some(3) && run.stderr.contains("needs") && run.stderr.contains("--memory"), "{run:?}");
    assert_eq!(view("1GiB").code, Some(4), "only the port is in the way");
}

#[test]
#[cfg(target_os = "linux")]
fn connections_share_an_image_file() {
    use std::io::{Read, Write};
    let view = ViewServer::start(SPHERES, "--size 800x600 --spp 1");
    view.finished();
    let length = view.get("image.exr").body.len();
    let resident = || {
        let status = std::fs::read_to_string(format!("/proc/{}/status", view.program.id())).expect("it runs");
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a size");
        1024 * line.trim().trim_end_matches(" kB").parse::<usize>().expect("a number")
    };
    let before = resident();
    let (address, rest) = view.url.strip_prefix("http://").expect("an URL").split_once('/').expect("a path");
    let open = |_: i32| {
        let mut stream = std::net::TcpStream::connect(address).expect("a connection");
        let request = format!("GET /{rest}image.exr HTTP/1.1\r\nHost: {address}\r\n\r\n");
        stream.write_all(request.as_bytes()).expect("sent");
        stream
    };
    let mut streams: Vec<_> = (0..50).map(open).collect();
    for stream in &mut streams {
        let mut head = [0; 15];
        stream.read_exact(&mut head).expect("a response");
        assert_eq!(&head, b"HTTP/1.1 200 OK");
    }
    let more = resident().saturating_sub(before);
    assert!(more < 15 * length, "50 connections take {more} bytes for a file of {length}");
}

#[test]
fn commands_move_the_camera_and_its_text_renders_the_same() {
    let view = ViewServer::start(SPHERES, "--spp 4");
    let unmoved = paste_camera(&view);
    assert!(unmoved.contains("look_from: (0.0, 0.0, 6.0)") && unmoved.contains("fov: 40.0"), "{unmoved}");
    let mut texts = vec![unmoved];
    for command in [
        json!({ "orbit": [0.1, 0.05] }),
        json!({ "look": [0.02, -0.01] }),
        json!({ "pan": [0.1, 0.2] }),
        json!({ "zoom": -2.5 }),
        json!({ "fly": [0.1, 0.0, -0.4] }),
        json!({ "look_at": [1.5, 0.0, 0.0] }),
    ] {
        view.post("camera", &command.to_string());
        let text = paste_camera(&view);
        assert!(!texts.contains(&text), "{command}: {text}");
        view.assert_shows("pasted.ron", "--spp 4");
        texts.push(text);
    }
    for useless in [json!({ "zoom": 1e300 }), json!({ "pan": [1e308, 1e308] }), json!({ "fly": [0, 0, 0] })] {
        view.post("camera", &useless.to_string());
        assert_eq!(paste_camera(&view), texts[texts.len() - 1], "{useless}");
    }
    for refused in ["", "{}", "{\"zoom\": \"in\"}", "{\"orbit\": [1]}", "[[[[[[[[[[", "\u{0}"] {
        assert_eq!(view.request("POST", "camera", refused).status, 400, "{refused}");
    }
    view.post("camera", &json!({ "reset": null }).to_string());
    assert_eq!(paste_camera(&view), texts[0]);
    view.assert_shows("scene.ron", "--spp 4");
}

/// A scene with the copied camera renders what the page shows. Returns the text.
fn assert_copied_camera_renders_the_same(scene: &str, camera: &str, options: &str) -> String {
    assert!(scene.contains(camera));
    let view = ViewServer::start(scene, options);
    let text = view.get("camera").text();
    view.place.write("pasted.ron", scene.replace(camera, &text));
    view.assert_shows("pasted.ron", options);
    text
}

#[test]
fn a_copied_camera_keeps_the_shutter_of_its_scene() {
    let scene = |cameras: &str| {
        format!(
            "({cameras} film: (size: (60, 40)), lights: [directional(direction: (0, 0, -1))],
            nodes: [(shape: sphere(radius: 0.5), animation: (keys: [(time: 0), (time: 1, transform: [translate(24, 0, 0)])]))])"
        )
    };
    let check = |shutter: &str| {
        let camera = format!("camera: (look_from: (0, 0, 5){shutter}),");
        for options in ["--spp 16", "--spp 16 --at-time 0.02"] {
            let text = assert_copied_camera_renders_the_same(&scene(&camera), &camera, options);
            assert!(text.contains(shutter.trim_start_matches(", ")), "{text}");
        }
    };
    check(", shutter: (0.0, 0.5)");
    check(", shutter: (0.0, 1.0)");
    check(", shutter: (0.25, 0.75)");
    check("");

    // Both shutters are relative to their common interval, from 0 to 0.5.
    let camera = r#"(name: "b", look_from: (0, 0, 5), shutter: (0, 0.25)),"#;
    let cameras = format!(r#"cameras: [(name: "a", look_from: (0, 0, 9), shutter: (0, 0.5)), {camera}],"#);
    let view = ViewServer::start(&scene(&cameras), "--spp 16 --camera b");
    let text = view.get("camera").text();
    assert!(text.contains("shutter: (0.0, 0.25)"), "{text}");
    view.place.write("pasted.ron", scene(&format!("{text} {cameras}")));
    let (_, shown) = view.finished();
    view.place.succeed("render pasted.ron --spp 16 --time 1h -o expected.png");
    assert!(shown == view.place.read("expected.png"), "{text}");
    assert!(view.place.read("pasted.ron").starts_with(b"(camera: ("));

    // One without a shutter is sharp where that of the other camera opens.
    let cameras =
        r#"cameras: [(name: "a", look_from: (0, 0, 9), shutter: (0.25, 0.75)), (name: "b", look_from: (0, 0, 5))],"#;
    let view = ViewServer::start(&scene(cameras), "--spp 16 --camera b");
    let text = view.get("camera").text();
    assert!(text.contains("shutter: (0.25, 0.25)"), "{text}");
    view.place.write("pasted.ron", scene(&text));
    let (_, shown) = view.finished();
    view.place.succeed("render pasted.ron --spp 16 --time 1h -o expected.png");
    assert!(shown == view.place.read("expected.png"), "{text}");

    let plain = "camera: (look_from: (0, 0, 5)),";
    let text = assert_copied_camera_renders_the_same(&scene(plain), plain, "--spp 16 --shutter 0,0.5");
    assert!(text.contains("shutter: (0.0, 0.5)"), "{text}");
}

#[test]
fn a_copied_camera_keeps_its_motion_until_it_is_moved() {
    let scene = |camera: &str| {
        format!(
            "({camera} film: (size: (60, 40)), lights: [directional(direction: (0, 0, -1))], nodes: [(shape: sphere(radius: 0.5))])"
        )
    };
    let check = |camera: &str, options: &str, expected: &str| {
        let text = assert_copied_camera_renders_the_same(&scene(camera), camera, options);
        assert!(text.contains(expected), "{expected}: {text}");
    };
    let moving = "camera: (transform: [translate(0, 0, 5)], motion: [translate(1, 0, 5)]),";
    check(moving, "--spp 16", "motion: [translate(1.0, 0.0, 5.0)]");
    check(moving, "--spp 16 --at-time 0 --shutter 0.25,0.5", "shutter: (0.25, 0.5)");
    check(moving, "--spp 16 --fov 25", "fov: 25.0");
    check(moving, "--spp 16 --look-from 1,2,4", "look_from: (1.0, 2.0, 4.0)");
    let animated = "camera: (shutter: (0, 1), animation: (keys: [(time: 0, look_from: (0, 0, 5)), (time: 1, look_from: (9, 0, 5), fov: 30)])),";
    check(animated, "--spp 16", "(time: 1.0, look_from: (9.0, 0.0, 5.0), fov: 30.0)");
    check(animated, "--spp 16 --at-time 0.5 --fov 25", "fov: 25.0");
    // Position and target of the pose are rounded.
    check("camera: (look_from: (3, 2, 4.1), up: (0.1, 1, 0.3)),", "--spp 16", "up: (0.1, 1.0, 0.3)");
    let aside = "camera: (look_from: (3, 2, 4.1)),";
    check(aside, "--spp 16 --look-at 0.1,0.2,0.3 --up 0.1,1,0.3", "look_at: (0.1, 0.2, 0.3)");
    for options in ["--up 0.1,1,0.3", "--look-at 0.1,0.2,0.3", "--look-from 1.7,2,4"] {
        let view = ViewServer::start(&scene(aside), &format!("--spp 16 {options}"));
        view.place.write("pasted.ron", scene(&view.get("camera").text()));
        view.assert_shows("pasted.ron", "--spp 16");
    }

    let view = ViewServer::start(&scene(moving), "--spp 16");
    let unmoved = view.get("camera").text();
    view.post("camera", &json!({ "orbit": [0.1, 0.05] }).to_string());
    let text = view.get("camera").text();
    assert!(!text.contains("motion"), "{text}");
    view.place.write("pasted.ron", scene(&text));
    view.assert_shows("pasted.ron", "--spp 16");
    view.post("camera", &json!({ "reset": null }).to_string());
    assert_eq!(view.get("camera").text(), unmoved);
}

#[test]
fn a_pick_returns_the_surface() {
    let view = ViewServer::start(SPHERES, "--spp 1");
    view.finished();
    // A distance of 6 and 40 degrees across 64 pixels: the balls' centres are 22 pixels from the middle.
    let pick = |x: u32, y: u32| view.post("pick", &json!([x, y]).to_string())["hit"].clone();
    let left = pick(26, 32);
    assert_eq!((&left["object"], &left["material"]), (&json!(["left ball"]), &json!("red")));
    let ([x, y, z], [i, j, k]) = (vector(&left["position"]), vector(&left["normal"]));
    let length = |x: f64, y: f64, z: f64| (x * x + y * y + z * z).sqrt();
    assert!((length(x + 1.5, y, z) - 1.0).abs() < 1e-9, "not on the ball: {left}");
    assert!([i - x - 1.5, j - y, k - z].iter().all(|part| part.abs() < 1e-9), "not its normal: {left}");
    let distance = left["distance"].as_f64().expect("a number");
    assert!((length(x, y, z - 6.0) - distance).abs() < 1e-9, "{left}");
    assert!((left["t"].as_f64().expect("a number") - (6.0 - z)).abs() < 1e-9, "t is the depth: {left}");
    assert_eq!(pick(70, 32)["object"], json!(["right ball"]));
    assert_eq!((pick(0, 0), pick(u32::MAX, 9)), (Value::Null, Value::Null));
    view.post("camera", &json!({ "look_at": left["position"] }).to_string());
    // Without a wait: the answer belongs to the latest view, not to the one before or to its preview.
    assert_eq!(pick(48, 32)["object"], json!(["left ball"]), "the target is in the middle");
    assert_eq!(view.post("pick", "[48, 32]")["view"], view.finished().0["view"]);
    assert_eq!(view.request("POST", "pick", "[-1, 0]").status, 400);
    view.post("camera", &json!({ "look_at": [-4.5, 0, 0] }).to_string());
    // 48 + 32 tan(51°) / tan(20°)
    assert_eq!(pick(156, 32), Value::Null, "the right ball is outside of the image");
}

#[test]
fn the_error_grows_smaller_within_its_interval() {
    let view = ViewServer::start(SPHERES, "--spp 64 --integrator path");
    let (state, _) = view.finished();
    let errors = state["errors"].as_array().expect("a list");
    assert!(errors.len() > 4, "{state}");
    let mut before = [0.0, f64::INFINITY];
    for error in errors {
        let [spp, rmse, low, high] = core::array::from_fn(|index| error[index].as_f64().expect("a number"));
        assert!(spp > before[0] && low <= rmse && rmse <= high, "{state}");
        before = [spp, rmse];
    }
    assert_eq!(before[0], 64.0);
    assert!(before[1] < errors[0][1].as_f64().expect("a number") / 2.0, "{state}");
    let more = view.get(&format!("frame?after=0&view={}&errors=3", state["view"]));
    let line = more.body.split(|byte| *byte == b'\n').next().expect("a line").to_vec();
    let rest: Value = serde_json::from_slice(&line).expect("JSON");
    assert_eq!(rest["errors"].as_array().map(Vec::as_slice), Some(&errors[3..]));
}

#[test]
fn foreign_requests_are_refused() {
    let view = ViewServer::start(SPHERES, "--spp 1");
    let page = view.page.as_str();
    let status = |head: &str| {
        let Answer { status, headers, body } = view.exchange(format!("{head}Connection: close\r\n\r\n").as_bytes());
        assert!(headers.contains("X-Content-Type-Options: nosniff") && headers.contains("Cache-Control: no-store"));
        assert!(status == 200 || body.len() < 100);
        status
    };
    let get = |path: &str, headers: &str| status(&format!("GET {path} HTTP/1.1\r\n{headers}"));
    for host in ["localhost:9", "127.0.0.1:80", "[::1]:7", "127.0.0.1"] {
        assert_eq!(get(page, &format!("Host: {host}\r\nOrigin: http://{host}\r\n")), 200, "{host}");
        assert_eq!(get(page, &format!("Host: {host}\r\n")), 200, "{host}");
    }
    for headers in [
        "Host: evil.example\r\n",
        "Host: localhost.evil.example:80\r\n",
        "Host: 10.0.0.1\r\n",
        "Host: localhost\r\nOrigin: http://evil.example\r\n",
        "Host: localhost\r\nOrigin: null\r\n",
        "Host: localhost\r\nOrigin: http://localhost:81\r\n",
        "",
    ] {
        assert_eq!(get(page, headers), 403, "{headers}");
    }
    let token = page.trim_matches('/');
    let other = format!("/{}/", token.chars().rev().collect::<String>());
    for path in [
        "/",
        "/favicon.ico",
        "//",
        &page[..page.len() - 1],
        &page[..9],
        &other,
        &page.to_uppercase(),
        "/frame",
        "/x/../",
    ] {
        assert_eq!(get(path, "Host: localhost\r\n"), 403, "{path}");
    }
    assert_eq!(get(&format!("{page}none"), "Host: localhost\r\n"), 404);
    assert_eq!(get(&format!("{page}../Cargo.toml"), "Host: localhost\r\n"), 404);
    let local = "HTTP/1.1\r\nHost: localhost\r\n";
    assert_eq!(status(&format!("DELETE {page} {local}")), 405);
    // A body would be taken for the next response.
    let requests = format!("HEAD {page} {local}\r\nGET {page}none {local}Connection: TE, close\r\n\r\n");
    let Answer { status: of_head, body: next, .. } = view.exchange(requests.as_bytes());
    assert!(of_head == 405 && next.starts_with(b"HTTP/1.1 404 "), "{}", String::from_utf8_lossy(&next));
    assert_eq!(status(&format!("OPTIONS {page}camera {local}")), 405);
    assert_eq!(status(&format!("GET {page} {local}Cookie: {}\r\n", "a".repeat(9000))), 431);
    assert_eq!(status(&format!("GET {page}{} {local}", "a".repeat(9000))), 431);
    assert_eq!(status(&format!("POST {page}camera {local}Content-Length: 5000\r\n")), 413);
    assert_eq!(status(&format!("POST {page}camera {local}Transfer-Encoding: chunked\r\n")), 501);
    assert_eq!(status(&format!("GET {page} HTTP/3.0\r\nHost: localhost\r\n")), 505);
    assert_eq!(status("nonsense\r\n"), 400);
    let csp = view.get("").headers;
    assert!(csp.contains("Content-Security-Policy: default-src 'none'; script-src 'self'"), "{csp}");
    view.assert_shows("scene.ron", "--spp 1");
}

#[test]
fn the_page_refers_to_nothing_outside() {
    let view = ViewServer::start(SPHERES, "--spp 1");
    let all = ["", "view.css", "view.js", "plot.js"].map(|path| view.get(path).text()).join("\n");
    let outside = all.replace("http://www.w3.org/2000/svg", "");
    assert!(!outside.contains("http:") && !outside.contains("https:") && !outside.contains("url(//"));
    let info = view.get("session").json();
    assert_eq!((&info["name"], &info["size"], &info["spp"]), (&json!("scene"), &json!([96, 64]), &json!(1)));
}

#[test]
#[cfg(target_os = "linux")]
fn a_closed_page_stops_the_work_which_goes_on_later() {
    let options = |spp: u64, threads| format!("--spp {spp} --size 240x160 --integrator path --threads {threads}");
    let view = ViewServer::start(SPHERES, &options(1 << 20, 1));
    thread::sleep(Duration::from_millis(500));
    assert!(view.processor_seconds() < 0.4, "nothing is rendered before a page is open");
    let (measured, _) = view.watch(|state| state["spp"].as_u64() >= Some(32));
    let rate = measured["spp"].as_f64().expect("a number") / measured["seconds"].as_f64().expect("a number");

    // The page counts as closed after four seconds, in most of which the program is stopped. Work that ends earlier, at a rate
    // that was measured too low, is doubled.
    let mut seconds = 2.0;
    let spp = loop {
        let spp = (seconds * rate) as u64 + 32;
        view.post("settings", &json!({ "spp": spp }).to_string());
        thread::sleep(Duration::from_millis(200));
        signal(&view.program, "STOP");
        thread::sleep(Duration::from_millis(4200));
        signal(&view.program, "CONT");
        thread::sleep(Duration::from_millis(300));
        let paused = view.processor_seconds();
        thread::sleep(Duration::from_millis(500));
        let work = view.processor_seconds() - paused;
        assert!(work < 0.05, "{work} s of work for a page that is closed");
        if view.frame(u64::MAX).0["is_finished"] == false {
            break spp;
        }
        assert!(seconds < 60.0, "the interruption came too late");
        seconds *= 2.0;
    };

    // It goes on, to the image of a render without interruptions.
    let (_, shown) = view.finished();
    view.place.succeed(&format!("render scene.ron {} --time 1h -o expected.png", options(spp, 2)));
    assert!(shown == view.place.read("expected.png"), "the interruption changes the image");
}

/// Interrupts a view that has begun to render.
#[cfg(unix)]
fn check_interrupt(mut view: ViewServer) {
    view.watch(|state| state["spp"].as_u64() >= Some(1));
    signal(&view.program, "INT");
    let deadline = Instant::now() + Duration::from_secs(20);
    let status = loop {
        if let Some(status) = view.program.try_wait().expect("a state") {
            break status;
        }
        assert!(Instant::now() < deadline, "the program goes on");
        thread::sleep(Duration::from_millis(20));
    };
    assert_eq!(status.code(), Some(130));
    assert_eq!(view.place.files(), ["scene.ron"]);
}

#[test]
#[cfg(unix)]
fn an_interrupt_ends_the_program() {
    check_interrupt(ViewServer::start(SPHERES, "--spp 1000000 --integrator path"));
}

/// Shells without job control start jobs in the background so.
#[test]
#[cfg(target_os = "linux")]
fn an_interrupt_ends_a_program_whose_parent_ignores_interrupts() {
    let place = Workplace::with("scene.ron", SPHERES);
    let mut command = Command::new("env");
    command.arg("--ignore-signal=INT").arg(env!("CARGO_BIN_EXE_rt-cli")).current_dir(place.path("."));
    command.args("view scene.ron --no-open --spp 1000000 --integrator path".split(' '));
    check_interrupt(ViewServer::start_command(place, command));
}

#[test]
fn connections_that_say_nothing_leave_room_for_others() {
    let view = ViewServer::start(SPHERES, "--spp 1");
    let port: u16 = view.url.split([':', '/']).nth(4).and_then(|port| port.parse().ok()).expect("a port");
    let silent: Vec<_> =
        (0..64).map(|_| std::net::TcpStream::connect(("127.0.0.1", port)).expect("connected")).collect();
    let deadline = Instant::now() + Duration::from_secs(10);
    while view.get("session").status != 503 {
        assert!(Instant::now() < deadline, "there is no limit");
    }
    drop(silent);
    while view.get("session").status != 200 {
        assert!(Instant::now() < deadline, "closed connections still count");
        thread::sleep(Duration::from_millis(20));
    }
}

#[test]
#[cfg(target_os = "linux")]
fn idle_connections_do_not_add_threads_without_bound() {
    let view = ViewServer::start(SPHERES, "--spp 1");
    view.finished();
    let threads = || {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", view.program.id())).expect("it runs");
        tasks.count()
    };
    let before = threads();
    let port: u16 = view.url.split([':', '/']).nth(4).and_then(|port| port.parse().ok()).expect("a port");
    let mut most = 0;
    let silent: Vec<_> = (0..600)
        .map(|_| {
            let connection = std::net::TcpStream::connect(("127.0.0.1", port)).expect("connected");
            most = most.max(threads());
            connection
        })
        .collect();
    // 64 connections and 8 refusals.
    assert!(most <= before + 72, "{most} threads for {} connections, {before} before", silent.len());
    drop(silent);
    let deadline = Instant::now() + Duration::from_secs(10);
    while !view.is_reachable() {
        assert!(Instant::now() < deadline, "closed connections still count");
        thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn what_is_bound_to_the_network_is_said_aloud() {
    let place = Workplace::with_scene();
    let mut command = place.command("view scene.ron --no-open --bind 0.0.0.0");
    let mut program =
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().expect("it starts");
    thread::sleep(Duration::from_secs(2));
    program.kill().expect("killed");
    let output = program.wait_with_output().expect("it ended");
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(stderr.contains("warning: --bind 0.0.0.0 opens the view to the network"), "{stderr}");
    assert!(stdout.contains("http://127.0.0.1:"), "{stdout}");
}

#[test]
fn failures_are_reported_in_the_terminal() {
    let place = Workplace::with_scene();
    place.write("bad.ron", "(nodes: [(shape: spher())])");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("an address").port();
    for (arguments, code, message) in [
        ("bad.ron".to_owned(), 3, "bad.ron:1:18: "),
        ("none.ron".to_owned(), 3, "none.ron"),
        (format!("scene.ron --port {port}"), 4, "choose another --port"),
        ("scene.ron --bind 192.0.2.1".to_owned(), 4, "cannot listen on 192.0.2.1"),
        ("scene.ron --bind localhost".to_owned(), 2, "--bind"),
        ("scene.ron --crop 0,0,8,8".to_owned(), 2, "--crop is not supported by `view`"),
        ("scene.ron --passes 2".to_owned(), 2, "--passes is not supported by `view`"),
        ("scene.ron --adaptive object-space".to_owned(), 2, "--adaptive is not supported by `view`"),
        ("scene.ron --min-spp 1".to_owned(), 2, "--min-spp is not supported by `view`"),
    ] {
        place.fails(code, &format!("view --no-open {arguments}"), message);
    }
}
