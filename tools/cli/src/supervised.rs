//! `simulate` and `cosim` in a child process: a crash, an end of the process or a call that does not return becomes one sentence.
use crate::parent::{self, Event};
use crate::progress::Progress;
use crate::{Command, Failure, simulate};
use cosim::child::{Call, Ending, Work, supervise};
use cosim::is_standard_input;
use std::ffi::OsString;
use std::io::Read;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// The arguments of the child process: those of the command that it runs.
#[derive(clap::Args)]
pub struct WorkArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Runs the command of this process, on `file` with the inputs of `input`, in a child.
pub fn run(file: &Path, input: Option<&Path>, patience: f64) -> Result<ExitCode, Failure> {
    let mut bytes = Vec::new();
    let reads = input.is_some_and(is_standard_input);
    if reads {
        std::io::stdin()
            .read_to_end(&mut bytes)
            .map_err(|e| Failure::new(format!("the standard input cannot be read: {e}")))?;
    }
    let arguments: Vec<OsString> =
        std::iter::once("work".into()).chain(std::env::args_os().skip(1)).collect();
    let work = Work {
        program: &crate::program()?,
        arguments: &arguments,
        patience: Duration::from_secs_f64(patience),
        shows_errors: true,
        standard_input: reads.then_some(&bytes),
    };
    let bar = Progress::new("simulating");
    let (mut said, mut complaints, mut code, mut failure) = (String::new(), String::new(), 2, None);
    let ending = supervise(&work, &mut |text| match serde_json::from_str(text) {
        Ok(Event::Say(text)) => said += &text,
        Ok(Event::Complain(text)) => complaints += &text,
        Ok(Event::Progress(share)) => bar.at(share),
        Ok(Event::Code(end)) => code = end,
        Ok(Event::Failed(sentence)) => failure = Some(sentence),
        Err(_) => {}
    });
    bar.finish();
    let ending = ending.map_err(|e| Failure::new(format!("a process for the FMU cannot be started: {e}")))?;
    let place = |call: &Call| match call.file.as_str() {
        "" => file.display().to_string(),
        file => file.to_owned(),
    };
    match ending {
        Ending::Done => {}
        Ending::Hung(call) => {
            return Err(Failure::new(format!(
                "{}: a call did not return within {patience} s, {} (--patience sets the limit)",
                place(&call),
                call.text
            )));
        }
        Ending::Died { cause, call } => {
            let text = &call.text;
            return Err(Failure::new(format!(
                "{}: the FMU ended its process, {text}: {cause}",
                place(&call)
            )));
        }
    }
    complaints.lines().for_each(parent::complain);
    crate::say(&said);
    failure.map_or(Ok(ExitCode::from(code)), |sentence| Err(Failure::new(sentence)))
}

/// The child process: runs the command and reports everything to the parent.
pub fn work(args: &WorkArgs) -> Result<ExitCode, Failure> {
    let channel = cosim::child::enter()?;
    parent::set(channel);
    let program = OsString::from("motor-fmu");
    let cli = crate::usage::parse(std::iter::once(&program).chain(&args.arguments))?;
    let outcome = match cli.command {
        Command::Simulate(args) => simulate::run(args),
        Command::Cosim(args) => crate::cosim::run(args),
        _ => Err(Failure::new("this command needs no child process")),
    };
    parent::send(match outcome {
        Ok(code) => Event::Code(code),
        Err(Failure(sentence)) => Event::Failed(sentence),
    });
    channel.end()
}
