//! Small FMUs without a fault, built in memory, and the means to spoil them.

use std::io::{Cursor, Write};

use archive::validate::{Finding, validate_static};
use zip::write::SimpleFileOptions;

/// An archive before it is zipped.
#[derive(Clone)]
pub struct Fmu {
    pub entries: Vec<(String, Vec<u8>)>,
}

/// Which fixture a case starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Base {
    Fmi2,
    Fmi3,
    Clocks,
}

impl Fmu {
    pub fn new(base: Base) -> Fmu {
        let mut fmu = Fmu { entries: Vec::new() };
        match base {
            Base::Fmi2 => {
                fmu.add("modelDescription.xml", FMI2);
                fmu.add("sources/model.c", "int model;");
                fmu.add("sources/buildDescription.xml", BUILD);
                fmu.add("terminalsAndIcons/terminalsAndIcons.xml", TERMINALS);
            }
            Base::Fmi3 => {
                fmu.add("modelDescription.xml", FMI3);
                fmu.add("sources/model.c", "int model;");
                fmu.add("sources/buildDescription.xml", BUILD);
                fmu.add("terminalsAndIcons/terminalsAndIcons.xml", TERMINALS);
            }
            Base::Clocks => {
                fmu.add("modelDescription.xml", CLOCKS);
                fmu.add("sources/model.c", "int model;");
                fmu.add("sources/buildDescription.xml", BUILD);
            }
        }
        fmu.add("terminalsAndIcons/port.png", "png");
        fmu.add("documentation/index.html", "<html/>");
        fmu.add("documentation/licenses/license.txt", "MIT");
        fmu
    }

    pub fn add(&mut self, name: &str, bytes: impl AsRef<[u8]>) {
        self.entries.push((name.to_owned(), bytes.as_ref().to_vec()));
    }

    pub fn remove(&mut self, name: &str) {
        self.entries.retain(|(n, _)| n != name);
    }

    /// Replaces a text that must occur, in the first file that has it.
    pub fn replace(&mut self, find: &str, by: &str) {
        for (_, bytes) in &mut self.entries {
            let text = String::from_utf8(bytes.clone()).unwrap_or_default();
            if text.contains(find) {
                *bytes = text.replacen(find, by, 1).into_bytes();
                return;
            }
        }
        panic!("the fixture has no {find:?}");
    }

    pub fn zip(&self) -> Vec<u8> {
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in &self.entries {
            writer.start_file(name.as_str(), SimpleFileOptions::default()).unwrap();
            writer.write_all(bytes).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }
}

/// Validates bytes as a file called `model.fmu`.
pub fn findings(bytes: &[u8]) -> Vec<Finding> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.fmu");
    std::fs::write(&path, bytes).unwrap();
    validate_static(&path).unwrap()
}

/// The codes found, each once.
pub fn codes(bytes: &[u8]) -> Vec<&'static str> {
    let mut codes: Vec<_> = findings(bytes).iter().map(|f| f.code).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

const FMI2: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Model" guid="{1}" variableNamingConvention="structured" generationDateAndTime="2026-01-31T12:00:00Z">
  <ModelExchange modelIdentifier="model" canGetAndSetFMUstate="true" canSerializeFMUstate="true">
    <SourceFiles><File name="model.c"/></SourceFiles>
  </ModelExchange>
  <CoSimulation modelIdentifier="model"/>
  <UnitDefinitions>
    <Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit>
    <Unit name="K/s"><BaseUnit K="1" s="-1"/></Unit>
    <Unit name="m"><BaseUnit m="1"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Temperature"><Real unit="K" displayUnit="degC" min="0"/></SimpleType>
    <SimpleType name="Mode"><Enumeration><Item name="off" value="1"/><Item name="on" value="2"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <LogCategories><Category name="logEvents"/><Category name="logAll"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="10" tolerance="1e-6" stepSize="0.1"/>
  <VendorAnnotations><Tool name="a"><x/></Tool><Tool name="b"/></VendorAnnotations>
  <ModelVariables>
    <ScalarVariable name="time" valueReference="0" causality="independent"><Real/></ScalarVariable>
    <ScalarVariable name="u" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="T" valueReference="2" causality="local" initial="exact"><Real declaredType="Temperature" start="300" reinit="true" nominal="300"/></ScalarVariable>
    <ScalarVariable name="der(T)" valueReference="3" causality="local"><Real unit="K/s" derivative="3"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real unit="K"/></ScalarVariable>
    <ScalarVariable name="p" valueReference="4" causality="parameter" variability="tunable"><Real start="2" min="1" max="3" nominal="2"/></ScalarVariable>
    <ScalarVariable name="q" valueReference="5" causality="calculatedParameter" variability="tunable"><Real/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="0" causality="parameter" variability="fixed"><Enumeration declaredType="Mode" start="1"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="1" causality="parameter" variability="fixed"><Integer start="3" min="0" max="5"/></ScalarVariable>
    <ScalarVariable name="c" valueReference="6" variability="constant"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="c2" valueReference="6" variability="constant"><Real start="1.0"/></ScalarVariable>
    <ScalarVariable name="hot" valueReference="0" causality="output" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="state[2].'a b'" valueReference="9"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="5" dependencies="2 3" dependenciesKind="dependent constant"/>
      <Unknown index="12" dependencies="3"/>
    </Outputs>
    <Derivatives><Unknown index="4" dependencies="2 3 6"/></Derivatives>
    <InitialUnknowns>
      <Unknown index="4" dependencies="2 3" dependenciesKind="dependent dependent"/>
      <Unknown index="5"/>
      <Unknown index="7" dependencies="6"/>
      <Unknown index="12" dependencies=""/>
    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"#;

const FMI3: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Model" instantiationToken="{1}" variableNamingConvention="structured" generationDateAndTime="2026-01-31T12:00:00Z">
  <ModelExchange modelIdentifier="model" canGetAndSetFMUState="true" canSerializeFMUState="true"/>
  <CoSimulation modelIdentifier="model" providesIntermediateUpdate="true" canReturnEarlyAfterIntermediateUpdate="true" fixedInternalStepSize="0.1"/>
  <UnitDefinitions>
    <Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/><DisplayUnit name="1/K" inverse="true"/></Unit>
    <Unit name="K/s"><BaseUnit K="1" s="-1"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <Float64Type name="Temperature" unit="K" displayUnit="degC" min="0"/>
    <EnumerationType name="Mode"><Item name="off" value="1"/><Item name="on" value="2"/></EnumerationType>
  </TypeDefinitions>
  <LogCategories><Category name="logEvents"/><Category name="logAll"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="10" tolerance="1e-6" stepSize="0.1"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent"/>
    <Float64 name="u" valueReference="1" causality="input" start="0" intermediateUpdate="true"/>
    <UInt64 name="n" valueReference="2" causality="structuralParameter" start="3" min="0"/>
    <Float64 name="T" valueReference="3" initial="exact" declaredType="Temperature" start="300 301 302" reinit="true" nominal="300"><Dimension valueReference="2"/><Alias name="T_winding" displayUnit="degC"/></Float64>
    <Float64 name="der(T)" valueReference="4" unit="K/s" derivative="3"><Dimension start="3"/></Float64>
    <Float64 name="y" valueReference="5" causality="output" unit="K"/>
    <Float64 name="p" valueReference="6" causality="parameter" variability="tunable" start="2" min="1" max="3"/>
    <Float64 name="q" valueReference="7" causality="calculatedParameter"/>
    <Enumeration name="mode" valueReference="8" causality="parameter" declaredType="Mode" start="1"/>
    <Boolean name="hot" valueReference="9" causality="output"/>
    <String name="file" valueReference="10" causality="parameter"><Start value="a"/></String>
    <Float64 name="z" valueReference="11"/>
    <Float64 name="c" valueReference="12" variability="constant" start="1"/>
    <Int32 name="k" valueReference="13" variability="discrete"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="5" dependencies="1 3" dependenciesKind="dependent constant"/>
    <Output valueReference="9"/>
    <ContinuousStateDerivative valueReference="4" dependencies="1 3 6"/>
    <InitialUnknown valueReference="4" dependencies="3 6" dependenciesKind="dependent dependent"/>
    <InitialUnknown valueReference="5"/>
    <InitialUnknown valueReference="7"/>
    <InitialUnknown valueReference="9"/>
    <EventIndicator valueReference="11"/>
  </ModelStructure>
</fmiModelDescription>
"#;

const CLOCKS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Clocks" instantiationToken="{1}">
  <CoSimulation modelIdentifier="model" hasEventMode="true"/>
  <ScheduledExecution modelIdentifier="model"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent"/>
    <Clock name="tick" valueReference="1" causality="input" intervalVariability="constant" intervalDecimal="0.1" priority="0"/>
    <Clock name="alarm" valueReference="2" causality="output" intervalVariability="triggered" clocks="1"/>
    <Int32 name="count" valueReference="3" clocks="1" previous="4" initial="exact" start="0"/>
    <Int32 name="last" valueReference="4" clocks="1" initial="exact" start="0"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="2" dependencies="1"/>
    <ClockedState valueReference="3"/>
  </ModelStructure>
</fmiModelDescription>
"#;

const BUILD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="model"><SourceFileSet language="C99"><SourceFile name="model.c"/></SourceFileSet></BuildConfiguration>
</fmiBuildDescription>
"#;

const TERMINALS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiTerminalsAndIcons fmiVersion="3.0">
  <GraphicalRepresentation><CoordinateSystem x1="-100" y1="-100" x2="100" y2="100" suggestedScalingFactorTo_mm="0.1"/></GraphicalRepresentation>
  <Terminals>
    <Terminal name="heat" matchingRule="plug">
      <TerminalMemberVariable variableName="u" memberName="u" variableKind="inflow"/>
      <TerminalMemberVariable variableName="y" memberName="y" variableKind="signal"/>
      <TerminalStreamMemberVariable inStreamMemberName="a" outStreamMemberName="b" inStreamVariableName="u" outStreamVariableName="y"/>
      <Terminal name="inner" matchingRule="sequence"/>
      <TerminalGraphicalRepresentation x1="0" y1="0" x2="1" y2="1" iconBaseName="port"/>
    </Terminal>
    <Terminal name="other" matchingRule="bus"/>
  </Terminals>
</fmiTerminalsAndIcons>
"#;
