use super::*;

const CELL: &str = r#"
scenario = "paper"
set = ["timing.mode=realtime"]
run_id = 7
url = "udpm://239.255.76.67:7667?ttl=1"
sim_url = "udpm://239.255.76.67:7668?ttl=0"

[robot-sim]
host = "robot-pc"
cpu = 1
priority = 49

[sensor-sim]
host = "robot-pc.lab"

[controller]
host = "control-pc"
"#;

fn parse(text: &str) -> Result<CellConfig, UpError> {
    CellConfig::parse("cell.toml", text, Path::new("."))
}

#[test]
fn each_host_gets_its_nodes_and_their_flags() {
    let cell = parse(CELL).unwrap();
    assert_eq!(cell.hosts(), ["robot-pc", "control-pc"]);
    assert_eq!(cell.on("robot-pc"), [Role::Sensor, Role::Robot]);
    assert_eq!(cell.on("control-pc.lab"), [Role::Controller]);
    assert_eq!(
        cell.started_on("robot-pc", Some(Role::Robot)).unwrap(),
        [Role::Robot]
    );
    let commands = cell.commands(&[Role::Robot], Path::new("/bin"), Path::new("/s.toml"));
    let words: Vec<_> = commands[0]
        .arguments
        .iter()
        .map(|word| word.to_str().unwrap())
        .collect();
    assert_eq!(
        words.join(" "),
        "--scenario /s.toml --url udpm://239.255.76.67:7667?ttl=1 --sim-url udpm://239.255.76.67:7668?ttl=0 \
         --run-id 7 --set timing.mode=realtime --cpu 1 --priority 49"
    );
    assert_eq!(commands[0].program, Path::new("/bin/robot-sim"));
}

#[test]
fn a_domain_is_left_out_or_not() {
    assert!(same_host("a", "A") && same_host("a.lab", "a") && same_host("a.lab", "a.lab"));
    assert!(!same_host("a.lab", "a.hall") && !same_host("a", "b"));
}

#[test]
fn what_does_not_work_is_refused_with_its_remedy() {
    for (from, to, message) in [
        (
            "timing.mode=realtime",
            "timing.seed=2",
            "cell.toml: timing.mode is lockstep, but",
        ),
        (
            ":7667?ttl=1",
            ":7667?ttl=0",
            "write url = \"udpm://239.255.76.67:7667?ttl=1\"",
        ),
        (
            "host = \"robot-pc.lab\"",
            "host = \"sensor-pc\"",
            "write sim_url = \"udpm://239.255.76.67:7668?ttl=1\"",
        ),
        (":7668", ":7667", "url and sim_url are both 239.255.76.67:7667"),
        (
            "udpm://239.255.76.67:7668?ttl=0",
            "memq://",
            "sim_url is \"memq://\", which stays in one process",
        ),
        (
            ":7668?ttl=0",
            ":0",
            "sim_url: LCM URL \"udpm://239.255.76.67:0\": port is \"0\"",
        ),
        (
            "cpu = 1",
            "cpu = 1024",
            "[robot-sim] cpu is 1024, above the limit of 1023; choose a number in 0..=1023",
        ),
        (
            "priority = 49",
            "priority = -1",
            "[robot-sim] priority is -1, below the limit of 0",
        ),
        (
            "host = \"control-pc\"",
            "host = \"\"",
            "[controller] host is \"\", which no host is called",
        ),
        ("run_id = 7", "", "missing field `run_id`"),
        ("cpu = 1", "cpus = 1", "unknown field `cpus`"),
        ("[controller]", "[controler]", "unknown field `controler`"),
        ("\"paper\"", "\"papre\"", "unknown scenario \"papre\""),
        (
            "\"paper\"",
            "\"none.toml\"",
            "the scenario ./none.toml can't be read",
        ),
        (
            "timing.mode=realtime",
            "timing.mode=real",
            "timing.mode is the unknown word \"real\"",
        ),
    ] {
        assert!(CELL.contains(from), "{from}");
        let error = parse(&CELL.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn two_problems_are_two_lines() {
    let text = CELL.replace("ttl=1", "ttl=0").replace("cpu = 1", "cpu = -1");
    let error = parse(&text).unwrap_err().to_string();
    assert_eq!(error.lines().count(), 2, "{error}");
    assert!(
        error.lines().all(|line| line.starts_with("cell.toml: ")),
        "{error}"
    );
}

#[test]
fn a_host_without_nodes_is_told_which_have_some() {
    let cell = parse(CELL).unwrap();
    let error = cell.started_on("desk", None).unwrap_err().to_string();
    assert!(
        error.starts_with("no node of cell.toml runs on host \"desk\"; its hosts are robot-pc, control-pc;"),
        "{error}"
    );
    let error = cell.started_on("robot-pc", Some(Role::Controller)).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("runs on \"control-pc\", not on \"robot-pc\"")
    );
}

#[test]
fn the_example_is_valid() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cells/two_hosts.toml");
    let cell = CellConfig::load(&path).unwrap();
    assert_eq!(cell.hosts().len(), 2);
}
